// Refusals of streamed setpoints.
#include "stream/setpoint_check.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <random>

namespace driveline::runtime {
namespace {

using stream::Refusal;
using stream::SetpointRecord;

constexpr std::int64_t kMs = 1'000'000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Two axes, -10 to 10, at most 5 per second.
SetpointCheck make_check() {
  return SetpointCheck{{{-10.0, 10.0, 5.0, 50.0}, {-10.0, 10.0, 5.0, 50.0}}};
}

SetpointRecord setpoint(std::uint64_t number, std::int64_t time_ns, double x = 0.0, double y = 0.0) {
  SetpointRecord record;
  record.number = number;
  record.kind = stream::RecordKind::kSetpoint;
  record.axis_count = 2;
  record.time_ns = time_ns;
  record.targets[0].position = x;
  record.targets[1].position = y;
  return record;
}

/// Why the second setpoint is refused after a first one at 0.
std::optional<Refusal> refusal_of(const SetpointRecord& record) {
  auto check = make_check();
  const auto first = setpoint(1, 0);
  EXPECT_TRUE(check.judge(first, nullptr).taken);
  const auto verdict = check.judge(record, &first);
  EXPECT_EQ(verdict.taken, !verdict.remark || verdict.remark == Refusal::kGap);
  return verdict.remark;
}

TEST(SetpointCheck, TakesWhatFollowsTheLast) {
  auto check = make_check();
  auto last = setpoint(1, 0, 9.0, -9.0);
  EXPECT_TRUE(check.judge(last, nullptr).taken) << "the first may be anywhere";
  for (std::uint64_t i = 2; i < 50; ++i) {
    const auto next = setpoint(i, static_cast<std::int64_t>(i) * kMs, 9.0, -9.0);
    const auto verdict = check.judge(next, &last);
    EXPECT_TRUE(verdict.taken);
    EXPECT_FALSE(verdict.remark);
    last = next;
  }
}

/// The undefined-behaviour sanitizer checks the difference of both times.
TEST(SetpointCheck, TimesAtBothEndsOfTheRangeDoNotOverflow) {
  constexpr std::int64_t kEnd = std::int64_t{1} << 61;
  auto check = make_check();
  const auto first = setpoint(1, -kEnd);
  EXPECT_TRUE(check.judge(first, nullptr).taken);
  EXPECT_TRUE(check.judge(setpoint(2, kEnd), &first).taken);
  for (const std::int64_t time_ns : {kEnd + 1, 2 * (kEnd - 1) + 2, -kEnd - 1, -2 * kEnd})
    EXPECT_EQ(make_check().judge(setpoint(1, time_ns), nullptr).remark, Refusal::kTooFarAhead) << time_ns;
}

TEST(SetpointCheck, NumbersAndTimesRise) {
  EXPECT_EQ(refusal_of(setpoint(2, kMs)), std::nullopt);
  EXPECT_EQ(refusal_of(setpoint(1, kMs)), Refusal::kDuplicate);
  EXPECT_EQ(refusal_of(setpoint(0, kMs)), Refusal::kOutOfOrder);
  EXPECT_EQ(refusal_of(setpoint(3, kMs)), Refusal::kGap);
  EXPECT_EQ(refusal_of(setpoint(2, 0)), Refusal::kOutOfOrder);
  EXPECT_EQ(refusal_of(setpoint(2, -kMs)), Refusal::kOutOfOrder);
  EXPECT_EQ(refusal_of(setpoint(2, std::numeric_limits<std::int64_t>::max())), Refusal::kTooFarAhead);
  EXPECT_EQ(refusal_of(setpoint(2, std::numeric_limits<std::int64_t>::min())), Refusal::kTooFarAhead);
}

TEST(SetpointCheck, OneThatWasRefusedIsNoGap) {
  auto check = make_check();
  const auto first = setpoint(1, 0);
  EXPECT_TRUE(check.judge(first, nullptr).taken);
  EXPECT_EQ(check.judge(setpoint(2, -kMs), &first).remark, Refusal::kOutOfOrder);
  const auto next = check.judge(setpoint(3, 3 * kMs), &first);
  EXPECT_TRUE(next.taken);
  EXPECT_FALSE(next.remark);
}

TEST(SetpointCheck, BoundsGoWithTheNamesOfPositions) {
  auto check = make_check();
  check.set_offset(0, 100.0);
  EXPECT_EQ(check.judge(setpoint(1, 0, 9.0), nullptr).remark, Refusal::kOutsideRange);
  EXPECT_TRUE(check.judge(setpoint(2, 0, 109.0), nullptr).taken);
}

TEST(SetpointCheck, ValuesAreFiniteAndWithinTheBounds) {
  for (const double wrong : {kInfinity, -kInfinity, std::nan("")}) {
    EXPECT_EQ(refusal_of(setpoint(2, kMs, wrong)), Refusal::kNotFinite);
    EXPECT_EQ(refusal_of(setpoint(2, kMs, 0.0, wrong)), Refusal::kNotFinite);
    auto record = setpoint(2, kMs);
    record.targets[1].velocity = wrong;
    EXPECT_EQ(refusal_of(record), Refusal::kNotFinite);
    record = setpoint(2, kMs);
    record.targets[1].acceleration = wrong;
    EXPECT_EQ(refusal_of(record), Refusal::kNotFinite);
    record = setpoint(2, kMs);
    record.targets[2].position = wrong;
    EXPECT_EQ(refusal_of(record), std::nullopt) << "there is no such axis";
  }
  EXPECT_EQ(refusal_of(setpoint(2, kMs, 10.1)), Refusal::kOutsideRange);
  EXPECT_EQ(refusal_of(setpoint(2, kMs, 0.0, -10.1)), Refusal::kOutsideRange);
  EXPECT_EQ(refusal_of(setpoint(2, kMs, 0.0049)), std::nullopt);
  EXPECT_EQ(refusal_of(setpoint(2, kMs, 0.0051)), Refusal::kTooFast);
  auto fast = setpoint(2, kMs);
  fast.targets[0].velocity = -5.1;
  EXPECT_EQ(refusal_of(fast), Refusal::kTooFast);
  auto three = setpoint(2, kMs);
  three.axis_count = 3;
  EXPECT_EQ(refusal_of(three), Refusal::kAxisCount);
}

TEST(SetpointCheck, TellsWhatOfWhichAxisWasWrong) {
  using Figure = SetpointFault::Figure;
  auto check = make_check();
  check.set_offset(1, 100.0);
  const auto first = setpoint(1, 0, 0.0, 100.0);
  ASSERT_TRUE(check.judge(first, nullptr).taken);
  std::uint64_t number = 1;
  const auto fault_of = [&](SetpointRecord record) {
    record.number = ++number;
    const auto verdict = check.judge(record, &first);
    EXPECT_FALSE(verdict.taken);
    return verdict.fault.value_or(SetpointFault{99, {}, 0.0, 0.0, 0.0});
  };
  auto fault = fault_of(setpoint(0, kMs, 0.0, 120.0));
  EXPECT_EQ(fault.axis, 1U);
  EXPECT_EQ(fault.figure, Figure::kPosition);
  EXPECT_EQ(fault.value, 120.0);
  EXPECT_EQ(fault.lowest, 90.0) << "as its requests count";
  EXPECT_EQ(fault.highest, 110.0);
  auto fast = setpoint(0, kMs, 0.0, 100.0);
  fast.targets[0].velocity = -6.0;
  fault = fault_of(fast);
  EXPECT_EQ(fault.axis, 0U);
  EXPECT_EQ(fault.figure, Figure::kVelocity);
  EXPECT_EQ(fault.value, -6.0);
  EXPECT_EQ(fault.highest, 5.0);
  fault = fault_of(setpoint(0, kMs, -0.02, 100.0));
  EXPECT_EQ(fault.axis, 0U);
  EXPECT_EQ(fault.figure, Figure::kStep);
  EXPECT_NEAR(fault.value, -20.0, 1e-9);
  EXPECT_EQ(fault.lowest, -5.0);
  auto endless = setpoint(0, kMs, 0.0, 100.0);
  endless.targets[1].acceleration = kInfinity;
  fault = fault_of(endless);
  EXPECT_EQ(fault.axis, 1U);
  EXPECT_EQ(fault.figure, Figure::kAcceleration);
  EXPECT_FALSE(check.judge(setpoint(2, 0), &first).fault) << "wrong as a whole";
}

TEST(SetpointCheck, NoGarbageIsTaken) {
  std::mt19937_64 random(11);
  auto check = make_check();
  const auto first = setpoint(1, 0);
  ASSERT_TRUE(check.judge(first, nullptr).taken);
  for (int i = 0; i < 100'000; ++i) {
    SetpointRecord record;
    std::array<std::uint64_t, sizeof(SetpointRecord) / 8> words{};
    for (auto& word : words) word = random();
    std::memcpy(static_cast<void*>(&record), words.data(), sizeof record);
    record.axis_count = 2;
    record.number = static_cast<std::uint64_t>(i) + 2;
    const auto verdict = check.judge(record, &first);
    if (!verdict.taken) continue;
    for (const auto& target : {record.targets[0], record.targets[1]}) {
      EXPECT_LE(std::abs(target.position), 10.0);
      EXPECT_LE(std::abs(target.velocity), 5.001);
    }
  }
}

}  // namespace
}  // namespace driveline::runtime
