#include "common/robot/map_sharer.h"

#include <algorithm>
#include <bit>

#include "common/dds/map_block.h"
#include "common/radio/pace.h"

namespace muster::robot {
namespace {

constexpr std::int64_t kTurn_ticks = 50;  // between looks for news in company: 5 s
constexpr std::int64_t kApart_ticks = 7;  // between one robot's turn and the next one's
constexpr double kSettled_s = 2;          // a neighbour who comes and goes is no newcomer each time
constexpr std::size_t kBlocks = 64;       // in one record, and so in a tick
constexpr std::size_t kHeader_bytes = 100;
constexpr int kFewVoxels = 100;  // four of five looks in company show fewer, mostly of edges that
constexpr double kFewWait_s =
    30;  // change their mind: they would cost more in headers than in words

int voxels(std::span<const map::SaidBlock> news) {
  int sum = 0;
  for (const map::SaidBlock& block : news) {
    for (std::size_t w = 0; w < block.said.free.size(); ++w)
      sum += std::popcount(block.said.free[w] | block.said.occupied[w]);
  }
  return sum;
}

}  // namespace

void MapSharer::look(const Knowledge& k) {
  std::set<RobotId> company;
  bool fresh = false;
  for (const auto& [id, mate] : k.teammates()) {
    if (!k.in_contact(id)) continue;
    company.insert(id);
    fresh |= !company_.contains(id);
  }
  company_ = std::move(company);
  if (company_.empty()) {
    telling_ = false;
    return;
  }
  const std::int64_t tick = k.now().us / kTick.us;
  const bool turn = (tick + kApart_ticks * k.self().value) % kTurn_ticks == 0;
  const bool settled = (k.now() - looked_).s() >= kSettled_s;
  if (!turn && !(fresh && settled)) return;
  looked_ = k.now();
  telling_ = true;
  for (const map::BlockKey& b : k.map().own_changes(cursor_)) changed_.insert(b);
}

std::vector<map::SaidBlock> MapSharer::take_news(const Knowledge& k) {
  std::vector<map::SaidBlock> news;
  for (auto it = changed_.begin(); it != changed_.end() && news.size() < kBlocks;) {
    if (auto block = k.map().news(*it)) {
      news.push_back(*block);
      ++it;
    } else {
      it = changed_.erase(it);
    }
  }
  return news;
}

void MapSharer::tell(Knowledge& k, std::span<const map::SaidBlock> news) {
  const mission::MapBlock record = dds::map_block(news, k.mission().resolution_m);
  const std::size_t at_most = radio::Pace(k.mission().radio).record_bytes() - kHeader_bytes;
  if (record.blocks.size() > at_most && news.size() > 1) {
    tell(k, news.first(news.size() / 2));
    tell(k, news.subspan(news.size() / 2));
    return;
  }
  k.publish(store::RecordClass::kMap, k.store().new_key(store::RecordClass::kMap), record);
  for (const map::SaidBlock& block : news) changed_.erase(block.key);
}

void MapSharer::step(Knowledge& k) {
  look(k);
  if (!telling_) return;
  const std::vector<map::SaidBlock> news = take_news(k);
  telling_ = news.size() == kBlocks;
  const bool few = voxels(news) < kFewVoxels;
  if (news.empty() || (few && (k.now() - told_).s() < kFewWait_s)) return;
  tell(k, news);
  told_ = k.now();
}

}  // namespace muster::robot
