#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/core/bytes.h"
#include "common/core/ids.h"
#include "common/store/database.h"
#include "common/store/record_store.h"

namespace muster::store {

/// What a robot has acknowledged, on disk: a SQLite file in WAL mode (DESIGN "Records"). One
/// transaction per tick, before anything is sent; a process killed at any instant starts again with
/// all that it ever told of.
///
/// When the disk fails (full, gone), the robot flies on: that is said once, nothing that is in the
/// file is lost, and the journal tries again every so often and then catches up.
///
/// What is in the file need not be in memory: the store reads large bodies of results from here.
class Journal : private Bodies {
 public:
  enum class Durability {
    kProcess,  ///< survives the process, in simulation
    kPower,    ///< survives the loss of power, on vehicles
  };

  /// Opens the journal of `robot`, or begins one. A file that is damaged is put aside as
  /// `<path>.damaged`, never deleted, and a new one begun. Throws BadInput when it is the journal
  /// of somebody else, Failure when there can be none.
  Journal(const std::string& path, RobotId robot, Durability durability);
  ~Journal() override;
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Where robots keep theirs below the directory of their results.
  static std::string path(const std::string& out, RobotId robot) {
    return out + "/state/" + std::to_string(robot.value) + ".db";
  }
  /// A fault of a simulation, between two starts: the disk with the journal at `path` is gone.
  static void lose(const std::string& path);
  /// What the journal at `path` holds, without taking it up: for who judges. Throws Failure.
  static std::vector<RecordHeader> kept(const std::string& path);
  /// Of the last start that was kept; 0: none was.
  std::uint64_t epoch() const { return epoch_; }

  /// Takes up what was kept: records in the order of their arrival, each handed to `take` once it
  /// is in the store; then the promises about streams. Outlives the store's use, as in `commit`.
  void restore(RecordStore& store, const std::function<void(const Record&)>& take);
  /// Own map blocks, as `keep_block` was given them.
  void restore_blocks(const std::function<void(std::uint64_t key, const Bytes&)>& take);

  /// Looks, as `keep_look` was given them, in that order.
  void restore_looks(const std::function<void(RegionId explored, const Bytes& sightings)>& take);

  /// Own map evidence that nobody was told of yet; part of the next commit.
  void keep_block(std::uint64_t key, Bytes voxels);
  /// One look of the own feature detector; part of the next commit. `explored`: on whose behalf.
  void keep_look(RegionId explored, Bytes sightings);
  /// Everything that changed in `store` since the last commit, in one transaction. Never throws.
  void commit(RecordStore& store);
  /// False while the disk refuses.
  bool works() const { return works_; }
  /// A fault of a simulation: from now on (or no longer) every commit fails as on a full disk.
  void set_disk_full(bool full) { disk_full_ = full; }

 private:
  struct Statements;

  void open(RobotId robot, Durability durability);
  void read(const RecordHeader& header, Bytes& into) const override;
  void write(const RecordStore& store);
  void write_streams(const RecordStore& store);
  bool has_news(const RecordStore& store) const;

  std::string path_;
  std::unique_ptr<Database> db_;
  std::unique_ptr<Statements> sql_;
  std::uint64_t epoch_ = 0;
  // Waiting for the next commit.
  std::map<std::uint64_t, Bytes> blocks_;
  std::vector<std::pair<RegionId, Bytes>> looks_;
  std::vector<const Record*> fresh_;  ///< written, but not committed yet

  /// How far the file is.
  struct Written {
    std::uint64_t version = 0, epoch = 0, voided = 0;
    std::array<std::uint64_t, kRecordClasses> changes{};
  };
  Written written_;
  bool works_ = true, disk_full_ = false;
  int skip_ = 0;  ///< commits not tried since the disk refused
};

}  // namespace muster::store
