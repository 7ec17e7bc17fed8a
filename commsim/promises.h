#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/mission/messages.h"
#include "common/store/record_store.h"

namespace muster::commsim {

/// The referee of memory: what robots told each other that they hold, against what their journals
/// do hold. It hears everything that is sent, so it need not believe anybody:
///
///     records on the air ──▶ which versions of which key there are
///     digests in beacons ──▶ who promised to hold which of them
///     a journal          ──▶ for every promised key: that version or a newer one; else it is lost
///
/// A robot that dies is judged at once, by the file that it leaves behind, and everyone at the end.
/// What nobody ever sent is no concern of anybody else. What a newer start of its author voids may
/// be gone, and so may all that was promised by a disk that is no more: what only that one held is
/// not forgotten but destroyed, and the features among it are named as redone.
class Promises {
 public:
  /// `message` is `by`'s own. What cannot be read promises nothing.
  void sent(RobotId by, const mission::Message& message);

  /// Counts what `robot` promised and does not hold; each (robot, author, class, key) once.
  void judge(RobotId robot, std::span<const store::RecordHeader> journal, SimTime now);
  /// `judge` by the journal at `path`; nothing when there is none.
  void judge_file(RobotId robot, const std::string& path, SimTime now);

  /// The script took `robot`'s journal: from now on it is held to what it promises anew.
  void disk_lost(RobotId robot);

  std::size_t lost() const { return lost_.size(); }
  /// `{"count", "journals", "records": [{robot, author, epoch, class, key, seq, t_s}, …]}`: how many
  /// were lost, the judged robots, and which, at most 50.
  nlohmann::json to_json() const;

 private:
  using Version = std::pair<std::uint64_t, std::uint64_t>;  // epoch, seq
  struct Name {
    RobotId author;
    store::RecordClass cls{};
    std::uint64_t key = 0;
    auto operator<=>(const Name&) const = default;
  };
  struct Promise {
    std::uint64_t complete = 0;
    store::SeqSet beyond;
    bool covers(std::uint64_t seq) const { return seq <= complete || beyond.contains(seq); }
  };
  struct Loss {
    Version version;
    SimTime at;
  };

  void digest(RobotId by, const mission::Beacon& beacon);
  std::optional<Version> promised(RobotId robot, const Name& name,
                                  const std::set<Version>& versions) const;

  std::map<Name, std::set<Version>> on_air_;
  std::map<RobotId, std::map<store::StreamId, Promise>> promises_;
  std::map<std::pair<RobotId, Name>, Loss> lost_;
  std::set<RobotId> judged_;
};

}  // namespace muster::commsim
