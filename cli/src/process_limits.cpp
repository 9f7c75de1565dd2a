#include "process_limits.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

namespace driveline::cli {
namespace {

/// Several times the largest stack use that was measured on any thread.
constexpr rlim_t kLeastStackKib = 1024;

}  // namespace

std::string too_little_stack() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return {};
  const auto kib = limit.rlim_cur / 1024;
  if (kib >= kLeastStackKib) return {};
  return fmt::format("the stack may have {} KiB here, {} are needed: ulimit -s 8192", kib, kLeastStackKib);
}

}  // namespace driveline::cli
