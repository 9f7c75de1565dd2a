#include "process_limits.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <array>
#include <new>
#include <optional>
#include <string_view>
#include <system_error>

namespace driveline::cli {
namespace {

/// Several times the largest stack use that was measured on any thread.
constexpr rlim_t kLeastStackKib = 1024;
/// Stack of the main thread that is there from the start, bytes.
constexpr std::size_t kStackBytes = std::size_t{512} << 10;

struct Limit {
  __rlimit_resource resource;
  std::string_view name;
  std::string_view option;
};
constexpr std::array kMemoryLimits{Limit{RLIMIT_AS, "address space", "-v"}, Limit{RLIMIT_DATA, "data segment", "-d"}};

/// The limit in KiB; none: there is no limit.
std::optional<rlim_t> limit_kib(__rlimit_resource resource) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur / 1024;
}

/// The limits of the memory of this process, to be appended to a sentence; may be empty.
std::string memory_limits() {
  std::string text;
  for (const auto& [resource, name, option] : kMemoryLimits) {
    if (const auto kib = limit_kib(resource)) {
      text += fmt::format("; the {} is limited to {} KiB here: ulimit {} unlimited", name, *kib, option);
    }
  }
  return text;
}

/// The kernel extends a stack down to the lowest address that is used; the pages in between need no memory.
[[gnu::noinline]] void use_stack() {
  std::array<volatile char, kStackBytes> room;  // NOLINT(cppcoreguidelines-pro-type-member-init): only its end is used
  room.front() = 1;
}

}  // namespace

std::string too_little_stack() {
  const auto kib = limit_kib(RLIMIT_STACK);
  if (!kib || *kib >= kLeastStackKib) return {};
  return fmt::format("the stack may have {} KiB here, {} are needed: ulimit -s 8192", *kib, kLeastStackKib);
}

std::string extend_stack() {
  // A stack that cannot grow is a SIGSEGV; a mapping of the same size shows beforehand whether it can.
  void* const trial = ::mmap(nullptr, kStackBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (trial == MAP_FAILED) return "no memory is left for the stack" + memory_limits();
  ::munmap(trial, kStackBytes);
  use_stack();
  return {};
}

std::string describe_end(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return "no memory is left" + memory_limits();
  const auto* failed = dynamic_cast<const std::system_error*>(&error);
  if (failed == nullptr || failed->code() != std::errc::resource_unavailable_try_again) return error.what();
  return fmt::format("no thread can be started: {}{}; ulimit -u limits the number of threads", error.what(),
                     memory_limits());
}

}  // namespace driveline::cli
