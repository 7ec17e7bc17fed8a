#include "gcs/contact_log.h"

namespace muster::gcs {

void ContactLog::update(const robot::Knowledge& knowledge) {
  for (const auto& [id, mate] : knowledge.teammates()) {
    if (!knowledge.in_contact(id)) {
      open_.erase(id);
      continue;
    }
    const auto [open, begins] = open_.try_emplace(id, contacts_.size());
    if (begins) contacts_.push_back({id, mate.heard, mate.heard});
    contacts_[open->second].until = mate.heard;
  }
}

}  // namespace muster::gcs
