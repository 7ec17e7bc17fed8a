#include "common/map/cell_clusters.h"

#include <algorithm>
#include <cmath>

#include "common/core/hash.h"

namespace muster::map {
namespace {

int extent(const VoxelKey& low, const VoxelKey& high) {
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z}) + 1;
}
void stretch(VoxelKey& low, VoxelKey& high, const VoxelKey& l, const VoxelKey& h) {
  low = {std::min(low.x, l.x), std::min(low.y, l.y), std::min(low.z, l.z)};
  high = {std::max(high.x, h.x), std::max(high.y, h.y), std::max(high.z, h.z)};
}

/// Disjoint sets; the smallest member stands for its set, so the outcome does not depend on how
/// they were joined.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) {
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    return parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

CellClusters::CellClusters(const std::vector<BlockKey>& blocks, const Neighbours& neighbours,
                           double resolution_m, double max_extent_m)
    : neighbours_(neighbours),
      cell_m2_(resolution_m * resolution_m),
      max_cells_(std::max(1, static_cast<int>(std::floor(max_extent_m / resolution_m + 1e-9)))) {
  for (const BlockKey& b : blocks) slots_.push_back({b, {}, {}, {}, {}, false});
}

void CellClusters::set(std::size_t index, const Plane& marks) {
  Slot& slot = slots_[index];
  if (slot.marks == marks) return;
  slot.marks = marks;
  changed_ = true;
  cut_into_pieces(slot);
  for (const int n : neighbours_[index]) {
    if (n >= 0) slots_[static_cast<std::size_t>(n)].stale_links = true;
  }
}

void CellClusters::cut_into_pieces(Slot& slot) {
  slot.pieces.clear();
  slot.label.assign(count(slot.marks) == 0 ? 0 : kBlockVoxels, 0);
  if (slot.label.empty()) return;
  constexpr std::uint16_t kVisited = 0xFFFF;
  std::uint32_t component = 0;
  for_each_bit(slot.marks, [&](int seed) {
    if (slot.label[static_cast<std::size_t>(seed)] != 0) return;
    std::vector<std::uint16_t> cells{static_cast<std::uint16_t>(seed)};
    slot.label[static_cast<std::size_t>(seed)] = kVisited;
    for (std::size_t head = 0; head < cells.size(); ++head) {
      const int x = cells[head] & 15, y = cells[head] >> 4 & 15, z = cells[head] >> 8;
      for (int nz = std::max(0, z - 1); nz <= std::min(15, z + 1); ++nz) {
        for (int ny = std::max(0, y - 1); ny <= std::min(15, y + 1); ++ny) {
          for (int nx = std::max(0, x - 1); nx <= std::min(15, x + 1); ++nx) {
            const int i = nx | ny << 4 | nz << 8;
            if (!bit(slot.marks, i) || slot.label[static_cast<std::size_t>(i)] != 0) continue;
            slot.label[static_cast<std::size_t>(i)] = kVisited;
            cells.push_back(static_cast<std::uint16_t>(i));
          }
        }
      }
    }
    add_piece(slot, std::move(cells), component++);
  });
}

void CellClusters::add_piece(Slot& slot, std::vector<std::uint16_t> cells,
                             std::uint32_t component) {
  VoxelKey low = voxel_in(slot.key, cells.front()), high = low;
  for (const std::uint16_t i : cells) {
    const VoxelKey k = voxel_in(slot.key, i);
    stretch(low, high, k, k);
  }
  if (extent(low, high) > max_cells_) {
    // Halved across its longest side.
    const int dx = high.x - low.x, dy = high.y - low.y, dz = high.z - low.z;
    const auto side = [&](const VoxelKey& k) {
      if (dx >= dy && dx >= dz) return 2 * k.x <= low.x + high.x;
      return dy >= dz ? 2 * k.y <= low.y + high.y : 2 * k.z <= low.z + high.z;
    };
    const auto middle = std::stable_partition(
        cells.begin(), cells.end(), [&](std::uint16_t i) { return side(voxel_in(slot.key, i)); });
    add_piece(slot, {cells.begin(), middle}, component);
    add_piece(slot, {middle, cells.end()}, component);
    return;
  }
  const auto label = static_cast<std::uint16_t>(slot.pieces.size() + 1);
  for (const std::uint16_t i : cells) slot.label[i] = label;
  std::sort(cells.begin(), cells.end());
  slot.pieces.push_back({std::move(cells), component, low, high});
}

void CellClusters::relink(std::size_t index) {
  Slot& slot = slots_[index];
  slot.links.clear();
  slot.stale_links = false;
  for (std::uint32_t a = 0; a < slot.pieces.size(); ++a) {
    for (std::uint32_t b = a + 1;
         b < slot.pieces.size() && slot.pieces[b].component == slot.pieces[a].component; ++b) {
      slot.links.push_back({a, static_cast<std::uint32_t>(index), b});
    }
  }
  for (std::uint32_t a = 0; a < slot.pieces.size(); ++a) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> touched;
    for (const std::uint16_t i : slot.pieces[a].cells) {
      const int x = i & 15, y = i >> 4 & 15, z = i >> 8;
      if (x > 0 && x < 15 && y > 0 && y < 15 && z > 0 && z < 15) continue;
      for (int d = 0; d < 27; ++d) {
        const int nx = x + d % 3 - 1, ny = y + d / 3 % 3 - 1, nz = z + d / 9 - 1;
        const int beside = ((nx >> 4) + 1) + 3 * ((ny >> 4) + 1) + 9 * ((nz >> 4) + 1);
        const int n = beside == 13 ? -1 : neighbours_[index][static_cast<std::size_t>(beside)];
        if (n <= static_cast<int>(index)) continue;  // every pair is linked from its first block
        const Slot& other = slots_[static_cast<std::size_t>(n)];
        if (other.label.empty()) continue;
        const std::uint16_t label =
            other.label[static_cast<std::size_t>((nx & 15) | (ny & 15) << 4 | (nz & 15) << 8)];
        if (label == 0) continue;
        const std::pair<std::uint32_t, std::uint32_t> to(static_cast<std::uint32_t>(n), label - 1u);
        if (std::find(touched.begin(), touched.end(), to) == touched.end()) touched.push_back(to);
      }
    }
    for (const auto& [other, piece] : touched) slot.links.push_back({a, other, piece});
  }
}

std::vector<CellCluster> CellClusters::clusters() {
  changed_ = false;
  std::vector<std::uint32_t> first(slots_.size());
  std::vector<VoxelKey> low, high;
  std::vector<std::uint32_t> sizes;
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    if (slots_[s].stale_links) relink(s);
    first[s] = static_cast<std::uint32_t>(low.size());
    for (const Piece& p : slots_[s].pieces) {
      low.push_back(p.low);
      high.push_back(p.high);
      sizes.push_back(static_cast<std::uint32_t>(p.cells.size()));
    }
  }
  Sets groups(low.size()), parts(low.size());
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    for (const Link& l : slots_[s].links) {
      const std::uint32_t a = first[s] + l.piece, b = first[l.other_slot] + l.other_piece;
      groups.join(a, b);
      const std::uint32_t pa = parts.find(a), pb = parts.find(b);
      VoxelKey lo = low[pa], hi = high[pa];
      stretch(lo, hi, low[pb], high[pb]);
      if (pa == pb || extent(lo, hi) > max_cells_) continue;
      const std::uint32_t joined = parts.join(pa, pb);
      low[joined] = lo;
      high[joined] = hi;
    }
  }
  std::vector<std::uint32_t> group_cells(low.size(), 0);
  for (std::uint32_t i = 0; i < low.size(); ++i) group_cells[groups.find(i)] += sizes[i];
  std::vector<CellCluster> result;
  std::vector<std::uint32_t> at(low.size(), 0xFFFFFFFFu);
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    for (std::uint32_t p = 0; p < slots_[s].pieces.size(); ++p) {
      const std::uint32_t i = first[s] + p, part = parts.find(i);
      if (at[part] == 0xFFFFFFFFu) {
        at[part] = static_cast<std::uint32_t>(result.size());
        result.push_back({{}, 0, group_cells[groups.find(i)] * cell_m2_});
      }
      CellCluster& c = result[at[part]];
      for (const std::uint16_t cell : slots_[s].pieces[p].cells)
        c.cells.push_back(voxel_in(slots_[s].key, cell));
    }
  }
  for (CellCluster& c : result) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(c.cells.data());
    c.fingerprint = hash_bytes({bytes, c.cells.size() * sizeof(VoxelKey)});
  }
  return result;
}

}  // namespace muster::map
