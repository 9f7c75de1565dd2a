#include "driveline/port/launch_times.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace driveline::port {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::initializer_list<unsigned> values) {
  Bytes bytes;
  for (const unsigned value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

/// `tc qdisc add dev a0 root etf clockid CLOCK_TAI delta 300000 offload` of iproute2 6.1, recorded with strace: the
/// kernel answers in the same form. The interface has index 3.
const Bytes kEtf =
    bytes_of({0x40, 0x00, 0x00, 0x00, 0x24, 0x00, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
              0x00, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF,
              0x00, 0x00, 0x00, 0x00, 0x08, 0x00, 0x01, 0x00, 0x65, 0x74, 0x66, 0x00, 0x14, 0x00, 0x02, 0x00,
              0x10, 0x00, 0x01, 0x00, 0xE0, 0x93, 0x04, 0x00, 0x0B, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00});
constexpr int kInterface = 3;
constexpr LaunchTimes kThere{CLOCK_TAI, 300us, true};

constexpr std::size_t kMessageLength = 0;
constexpr std::size_t kKindLength = 36;
constexpr std::size_t kKind = 40;
constexpr std::size_t kFlagsPlace = 60;

Bytes changed(std::size_t place, unsigned value) {
  Bytes bytes = kEtf;
  bytes[place] = static_cast<std::byte>(value);
  return bytes;
}

Bytes joined(const Bytes& first, const Bytes& second) {
  Bytes both = first;
  both.insert(both.end(), second.begin(), second.end());
  return both;
}

TEST(LaunchTimes, AreReadFromWhatTheKernelSaysOfItsDisciplines) {
  EXPECT_EQ(etf_in(kEtf, kInterface), kThere);
  EXPECT_EQ(etf_in(changed(kFlagsPlace, 0), kInterface), (LaunchTimes{CLOCK_TAI, 300us, false}));
}

TEST(LaunchTimes, AreThoseOfThisInterfaceAndOfThisDiscipline) {
  EXPECT_FALSE(etf_in(kEtf, 4));
  EXPECT_FALSE(etf_in(changed(kKind, 'x'), kInterface));
  EXPECT_FALSE(etf_in(changed(kKindLength, 7), kInterface)) << "et";
  EXPECT_FALSE(etf_in({}, kInterface));
  // One of several, as below mqprio or taprio, in the same answer.
  EXPECT_EQ(etf_in(joined(changed(kKind, 'x'), kEtf), kInterface), kThere);
}

TEST(LaunchTimes, OfADamagedAnswerAreNone) {
  for (std::size_t size = 0; size < kEtf.size(); ++size)
    EXPECT_FALSE(etf_in(std::span(kEtf).first(size), kInterface)) << size << " bytes";
  for (const unsigned length : {0U, 1U, 15U, 0x41U, 0xFFU})
    EXPECT_FALSE(etf_in(changed(kMessageLength, length), kInterface)) << "message of " << length;
  for (const unsigned length : {0U, 3U, 0xFFU})
    EXPECT_FALSE(etf_in(changed(kKindLength, length), kInterface)) << "attribute of " << length;
  // Whatever the value of a byte, nothing beyond the answer is read (which a sanitizer checks).
  for (std::size_t place = 0; place < kEtf.size(); ++place) {
    for (const unsigned value : {0U, 1U, 0x7FU, 0xFFU}) static_cast<void>(etf_in(changed(place, value), kInterface));
  }
}

TEST(LaunchTimes, AreUsableOnAClockThatThisProgramCanReadAndWhenFramesComeSoonEnough) {
  for (const clockid_t clock : {CLOCK_TAI, CLOCK_MONOTONIC}) {
    const LaunchTimes times{clock, 20us, true};
    EXPECT_EQ(usable_launch_times(times, "eth1", 20us), times);
  }
  const auto sentence = [](const std::optional<LaunchTimes>& etf) {
    const auto refused = usable_launch_times(etf, "eth1", 20us);
    return refused ? "" : refused.error().message;
  };
  EXPECT_EQ(
      sentence(std::nullopt),
      "Interface 'eth1' has no launch times: it has no queueing discipline `etf`; `tc qdisc replace dev eth1 root "
      "etf clockid CLOCK_TAI delta 20000 offload` sets it up where the card has launch times.");
  EXPECT_EQ(
      sentence(LaunchTimes{CLOCK_REALTIME, 20us, true}),
      "The queueing discipline `etf` of interface 'eth1' has clock 0, CLOCK_TAI is expected; `tc qdisc replace dev "
      "eth1 root etf clockid CLOCK_TAI delta 20000 offload` sets it up where the card has launch times.");
  EXPECT_EQ(
      sentence(LaunchTimes{CLOCK_TAI, 20'001ns, true}),
      "The queueing discipline `etf` of interface 'eth1' takes frames 20001 ns before they leave (delta), and they "
      "are handed over 20000 ns before.");
}

}  // namespace
}  // namespace driveline::port
