#pragma once

#include <map>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::gcs {

/// When a robot was in contact with the station.
struct Contact {
  RobotId robot;
  SimTime from, until;
};

/// Whom the station met, and when, since it started.
class ContactLog {
 public:
  /// Once per tick.
  void update(const robot::Knowledge& knowledge);
  const std::vector<Contact>& contacts() const {
    return contacts_;
  }  ///< in order of their beginning

 private:
  std::vector<Contact> contacts_;
  std::map<RobotId, std::size_t> open_;  // index of the one that goes on
};

}  // namespace muster::gcs
