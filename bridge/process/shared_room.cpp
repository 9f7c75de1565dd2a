#include "shared_room.hpp"

namespace driveline::bridge {

bool shared_memory_has_room() noexcept {
  struct statvfs facts = {};
  return ::statvfs("/dev/shm", &facts) != 0 || has_shared_room(facts);
}

}  // namespace driveline::bridge
