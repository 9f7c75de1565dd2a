#include "counted_cycle.hpp"

#include <sys/mman.h>

#include <cerrno>
#include <cstddef>
#include <cstring>

#include "rt/rt_support.hpp"

namespace driveline::bus_test {
namespace {

/// Uses more of the stack than a cycle does.
[[gnu::noinline]] void use_stack() noexcept {
  unsigned char room[256 * 1024];
  std::memset(room, 1, sizeof room);
  asm volatile("" : : "r"(&room[0]) : "memory");
}

}  // namespace

LockedMemory::LockedMemory() {
  if (rt::test::kSanitized) {
    refusal_ = "a sanitizer maps memory in the cycle in this build";
    return;
  }
  use_stack();
  if (::mlockall(MCL_CURRENT) != 0 || ::mlockall(MCL_FUTURE | MCL_ONFAULT) != 0)
    refusal_ = std::string("memory cannot be locked: ") + std::strerror(errno);
}

LockedMemory::~LockedMemory() {
  ::munlockall();
}

}  // namespace driveline::bus_test
