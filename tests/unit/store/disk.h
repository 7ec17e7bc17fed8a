#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/store/journal.h"

namespace muster::store {

/// What is left of a robot when its process is killed. A process opens it, restores from it, and
/// commits to it; `kill` ends the process and nothing else.
class Disk {
 public:
  virtual ~Disk() = default;
  /// The epoch of the last start that was kept; 0: none was.
  virtual std::uint64_t open() = 0;
  virtual void restore(RecordStore& store) = 0;
  virtual void commit(RecordStore& store) = 0;
  virtual void kill() = 0;
  virtual void wipe() = 0;
};

/// The product's own journal, in a file; what is killed leaves the file as it is, nothing closed.
class FileDisk final : public Disk {
 public:
  FileDisk(std::string path, RobotId robot) : path_(std::move(path)), robot_(robot) { wipe(); }
  ~FileDisk() override { wipe(); }

  std::uint64_t open() override {
    journal_ = std::make_unique<Journal>(path_, robot_, Journal::Durability::kProcess);
    return journal_->epoch();
  }
  void restore(RecordStore& store) override {
    journal_->restore(store, [](const Record&) {});
  }
  void commit(RecordStore& store) override { journal_->commit(store); }
  void kill() override {
    if (!journal_) return;
    for (const char* part : {"", "-wal"}) {
      if (std::filesystem::exists(path_ + part))
        std::filesystem::copy_file(path_ + part, path_ + ".killed" + part);
    }
    journal_.reset();
    for (const char* part : {"", "-wal"}) {
      if (std::filesystem::exists(path_ + ".killed" + part))
        std::filesystem::rename(path_ + ".killed" + part, path_ + part);
    }
  }
  void wipe() override {
    journal_.reset();
    for (const char* part : {"", "-wal", "-shm"}) std::filesystem::remove(path_ + part);
  }

 private:
  std::string path_;
  RobotId robot_;
  std::unique_ptr<Journal> journal_;
};

/// The same without files, for thousands of storms: what was committed survives, whole commits
/// only.
class MemoryDisk final : public Disk {
 public:
  std::uint64_t open() override {
    written_ = {};
    version_ = 0;
    return epoch_;
  }
  void restore(RecordStore& store) override {
    std::map<std::uint64_t, const Record*> by_arrival;
    for (const auto& [name, kept] : records_) by_arrival[kept.arrival] = &kept.record;
    for (const auto& [arrival, record] : by_arrival) store.merge(*record);
    for (const auto& [id, stream] : streams_) store.resume(id, stream.first, stream.second);
  }
  void commit(RecordStore& store) override {
    if (store.version() == version_ && store.epoch() == epoch_) return;
    epoch_ = store.epoch();
    for (std::uint32_t c = 1; c <= kRecordClasses; ++c) {
      const RecordClass cls{c};
      for (const Record* r : store.changes(cls, written_[cls]))
        records_[{r->header.author.robot, cls, r->header.key}] = {*r, ++arrivals_};
    }
    for (const auto& [id, stream] : store.streams()) {
      if (stream.version > version_) streams_[id] = {stream.complete, stream.seen.ranges()};
    }
    version_ = store.version();
  }
  void kill() override {}
  void wipe() override { *this = {}; }

 private:
  struct Kept {
    Record record;
    std::uint64_t arrival = 0;
  };
  std::uint64_t epoch_ = 0, version_ = 0, arrivals_ = 0;
  std::map<RecordClass, std::uint64_t> written_;
  std::map<std::tuple<RobotId, RecordClass, std::uint64_t>, Kept> records_;
  std::map<StreamId, std::pair<std::uint64_t, std::vector<SeqRange>>> streams_;
};

}  // namespace muster::store
