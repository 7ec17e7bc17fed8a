#include "commsim/air_log.h"

#include <numeric>

#include "common/core/error.h"

namespace muster::commsim {
namespace {

constexpr Duration kBin{2'000'000};

}  // namespace

AirLog::AirLog(const std::string& path, std::vector<RobotId> robots)
    : file_(path), robots_(std::move(robots)), cells_(robots_.size() * robots_.size()) {
  if (!file_) throw Failure(path + ": cannot be written");
  file_ << "t_s,from,to,heard,heard_bytes,dropped_bytes";
  for (std::size_t i = 1; i < kDrops; ++i) file_ << ',' << to_string(static_cast<Drop>(i));
  file_ << '\n';
}

void AirLog::advance(SimTime now) {
  const std::int64_t bin = now.us / kBin.us;
  if (bin == bin_) return;
  write(false);
  bin_ = bin;
}

void AirLog::heard(std::size_t from, std::size_t to, std::size_t bytes) {
  Cell& c = cell(from, to);
  ++c.heard;
  c.heard_bytes += bytes;
  c.remarkable = true;
}

void AirLog::dropped(std::size_t from, std::size_t to, std::size_t bytes, Drop reason) {
  Cell& c = cell(from, to);
  ++c.drops.at(static_cast<std::size_t>(reason));
  c.dropped_bytes += bytes;
  const bool silence = reason == Drop::kRange || reason == Drop::kDead || reason == Drop::kWall ||
                       reason == Drop::kPaused;
  c.remarkable = c.remarkable || !silence;
}

void AirLog::finish() {
  write(true);
  file_.flush();
}

void AirLog::write(bool all) {
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& c = cells_[i];
    const std::uint64_t drops = std::accumulate(c.drops.begin(), c.drops.end(), std::uint64_t{0});
    if (!c.remarkable && !(all && drops > 0)) continue;
    file_ << (bin_ * kBin.us) / 1'000'000 << ',' << robots_[i / robots_.size()].value << ','
          << robots_[i % robots_.size()].value << ',' << c.heard << ',' << c.heard_bytes << ','
          << c.dropped_bytes;
    for (std::size_t reason = 1; reason < kDrops; ++reason) file_ << ',' << c.drops[reason];
    file_ << '\n';
    c = {};
  }
}

}  // namespace muster::commsim
