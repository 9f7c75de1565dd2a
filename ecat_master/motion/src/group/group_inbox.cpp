#include "group_inbox.hpp"

namespace driveline::motion {

std::uint64_t GroupInbox::submit(const GroupRequest& request) noexcept {
  if (const auto kind = group_stop(request.command)) {
    const auto id = table_.add();
    const auto replaced = stops_.put(0, *kind, {id, request});
    table_.set_if_waiting(replaced, {RequestPhase::kAborted, GroupError::kNone, 0});
    return id;
  }
  if (requests_.size() >= requests_.capacity()) return 0;
  const auto id = table_.add();
  requests_.try_push({id, request});
  ++queued_;
  return id;
}

/// Ends a queued request that a later stop has overtaken, and would have ended in the order of the requests.
bool GroupInbox::overtaken(const NumberedGroupRequest& next) noexcept {
  const auto command = next.request.command;
  const auto weakest = ended_by(command);
  if (!weakest || next.id > stops_.taken_from(0, *weakest)) return false;
  // The release of an earlier stop must not release this one; it has been done all the same.
  const bool release = command == GroupCommand::kReleaseStop;
  table_.set(next.id, {release ? RequestPhase::kDone : RequestPhase::kAborted, GroupError::kNone, 0});
  return true;
}

}  // namespace driveline::motion
