#include "common/map/own_tree.h"

#include <algorithm>
#include <array>

namespace muster::map {
namespace {

using octomap::OcTree;
using octomap::OcTreeNode;

constexpr int kTreeOffset = 32768;     // OctoMap's key of the voxel at the origin
constexpr unsigned kBlockLevels = 4;   // 2⁴ voxels a side
constexpr std::int16_t kMixed = 1000;  // no one value

/// For every cube of 2^level voxels: the value they share, or kMixed.
struct Pyramid {
  std::array<std::array<std::int16_t, kBlockVoxels>, kBlockLevels + 1> level;

  explicit Pyramid(std::span<const Evidence, kBlockVoxels> evidence) {
    std::copy(evidence.begin(), evidence.end(), level[0].begin());
    for (unsigned l = 1; l <= kBlockLevels; ++l) {
      const int side = kBlockSide >> l;
      for (int z = 0; z < side; ++z) {
        for (int y = 0; y < side; ++y) {
          for (int x = 0; x < side; ++x)
            level[l][index(l, x, y, z)] = shared(l - 1, 2 * x, 2 * y, 2 * z);
        }
      }
    }
  }
  static std::size_t index(unsigned l, int x, int y, int z) {
    const int side = kBlockSide >> l;
    const int i = x + side * (y + side * z);
    return static_cast<std::size_t>(i);
  }
  std::int16_t at(unsigned l, int x, int y, int z) const { return level[l][index(l, x, y, z)]; }

 private:
  std::int16_t shared(unsigned l, int x, int y, int z) const {
    const std::int16_t first = at(l, x, y, z);
    for (int i = 1; i < 8; ++i) {
      if (at(l, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)) != first) return kMixed;
    }
    return first;
  }
};

/// `fresh`: just created, so without children because nothing is known, not because it was pruned.
void write(OcTree& tree, OcTreeNode* node, bool fresh, const Pyramid& pyramid, unsigned l, int x,
           int y, int z) {
  const std::int16_t value = pyramid.at(l, x, y, z);
  if (l == 0 || (value != kMixed && !tree.nodeHasChildren(node))) {
    node->setLogOdds(static_cast<float>(value) * kEvidenceStep);
    return;
  }
  if (!fresh && !tree.nodeHasChildren(node)) tree.expandNode(node);
  for (int i = 0; i < 8; ++i) {
    const int cx = 2 * x + (i & 1), cy = 2 * y + (i >> 1 & 1), cz = 2 * z + (i >> 2);
    if (pyramid.at(l - 1, cx, cy, cz) == kNoEvidence) continue;
    const unsigned child = static_cast<unsigned>(i);
    const bool exists = tree.nodeChildExists(node, child);
    OcTreeNode* next = exists ? tree.getNodeChild(node, child) : tree.createNodeChild(node, child);
    write(tree, next, !exists, pyramid, l - 1, cx, cy, cz);
  }
  if (!tree.pruneNode(node)) node->updateOccupancyChildren();
}

void descend(OcTree& tree, OcTreeNode* node, bool fresh, const Pyramid& pyramid,
             const octomap::OcTreeKey& key, unsigned levels_below) {
  if (levels_below == kBlockLevels) {
    write(tree, node, fresh, pyramid, kBlockLevels, 0, 0, 0);
    return;
  }
  const unsigned child = octomap::computeChildIdx(key, static_cast<int>(levels_below) - 1);
  if (!fresh && !tree.nodeHasChildren(node)) tree.expandNode(node);
  const bool exists = tree.nodeChildExists(node, child);
  OcTreeNode* next = exists ? tree.getNodeChild(node, child) : tree.createNodeChild(node, child);
  descend(tree, next, !exists, pyramid, key, levels_below - 1);
  if (!tree.pruneNode(node)) node->updateOccupancyChildren();
}

}  // namespace

void write_block(OcTree& tree, BlockKey b, std::span<const Evidence, kBlockVoxels> evidence) {
  const Pyramid pyramid(evidence);
  if (pyramid.at(kBlockLevels, 0, 0, 0) == kNoEvidence) return;
  const auto key_of = [](int block) {
    return static_cast<octomap::key_type>(block * kBlockSide + kTreeOffset);
  };
  const octomap::OcTreeKey key(key_of(b.x), key_of(b.y), key_of(b.z));
  if (!tree.getRoot()) {
    // The root can only be made together with a first voxel; the block's own walk overwrites it.
    int first = 0;
    while (evidence[static_cast<std::size_t>(first)] == kNoEvidence) ++first;
    octomap::OcTreeKey voxel(static_cast<octomap::key_type>(key[0] + (first & 15)),
                             static_cast<octomap::key_type>(key[1] + (first >> 4 & 15)),
                             static_cast<octomap::key_type>(key[2] + (first >> 8)));
    tree.setNodeValue(
        voxel, static_cast<float>(evidence[static_cast<std::size_t>(first)]) * kEvidenceStep);
  }
  descend(tree, tree.getRoot(), false, pyramid, key, tree.getTreeDepth());
}

}  // namespace muster::map
