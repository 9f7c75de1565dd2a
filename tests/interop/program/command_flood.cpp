// A compromised bridge, for test_commands.py: writes 100,000 commands in a second into the memory shared with the line,
// none of which must be executed, and prints on stderr how many were accepted into it.
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <string_view>
#include <thread>
#include <variant>

#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

using namespace driveline;
using namespace std::chrono_literals;

namespace {

constexpr int kSupervisor = 3;  // descriptor of a helper's supervisor
constexpr std::int64_t kPerMillisecond = 100;
constexpr std::uint64_t kParticipants = 200;

struct Refused {
  const char* axis;
  snapshot::CommandKind kind;
  double target;
};

// Without a lease, for a missing axis, with invalid numbers, of an unknown kind.
constexpr auto kRefused = std::to_array<Refused>({
    {"x", snapshot::CommandKind::kJog, 1.0},
    {"y", snapshot::CommandKind::kMoveAbsolute, 1.0},
    {"y", snapshot::CommandKind::kJog, 1e300},
    {"x", snapshot::CommandKind::kJog, std::numeric_limits<double>::quiet_NaN()},
    {"y", snapshot::CommandKind::kMoveRelative, -std::numeric_limits<double>::infinity()},
    {"x", snapshot::CommandKind::kDisable, 0.0},
    {"y", snapshot::CommandKind::kRelease, 0.0},
    {"x", snapshot::CommandKind::kRenew, 0.0},
    {"nowhere", snapshot::CommandKind::kAcquire, 0.0},
    {"", snapshot::CommandKind{0xDEADBEEF}, 0.0},
});

snapshot::CommandRecord command(std::uint64_t number) {
  const auto& refused = kRefused[number % kRefused.size()];
  snapshot::CommandRecord record;
  record.participant[0] = static_cast<std::uint8_t>(number % kParticipants);
  record.client.set("flood");
  record.axis.set(refused.axis);
  record.number = number;
  record.lease = number;
  record.kind = static_cast<std::uint32_t>(refused.kind);
  record.target = refused.target;
  return record;
}

/// Whether the line still needs its bridge.
bool wanted() {
  char byte = 0;
  const auto got = ::recv(kSupervisor, &byte, 1, MSG_DONTWAIT);
  return got != 0;
}

}  // namespace

int main(int argc, char** argv) try {
  int descriptor = -1;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::string_view{argv[i]} == "--commands-fd") descriptor = std::atoi(argv[i + 1]);
  }
  auto mapped = rt::SharedMapping::open(descriptor, snapshot::command_layout());
  const auto* memory = std::get_if<rt::SharedMapping>(&mapped);
  if (memory == nullptr || ::send(kSupervisor, "R", 1, MSG_NOSIGNAL) != 1) return 1;
  rt::SharedRingWriter<snapshot::CommandRecord> ring(*memory);
  const auto begin = std::chrono::steady_clock::now();
  std::uint64_t written = 0;
  std::chrono::milliseconds elapsed{0};
  while (wanted()) {
    elapsed = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - begin);
    for (const auto due = static_cast<std::uint64_t>(elapsed.count() * kPerMillisecond); written < due; ++written)
      ring.try_push(command(written + 1));
    std::this_thread::sleep_for(1ms);
  }
  std::fprintf(stderr, "flood: %llu commands in %lld ms, %llu without room\n", static_cast<unsigned long long>(written),
               static_cast<long long>(elapsed.count()), static_cast<unsigned long long>(ring.dropped()));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "flood: %s\n", error.what());
  return 1;
}
