// The master's part of 60B8h to 60BDh; the bits are in MSD manual Tables 14.1 to 14.3.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "driveline/motion/drive/touch_probe.hpp"

namespace driveline::motion {
namespace {

using Phase = TouchProbe::Phase;

const PdoConfiguration kProbePdos{
    {{0x1600, {{0x6040, 0, 16}, {0x60B8, 0, 16}}}},
    {{0x1A00, {{0x60B9, 0, 16}, {0x60BA, 0, 32}, {0x60BB, 0, 32}}}, {0x1A01, {{0x60BC, 0, 32}, {0x60BD, 0, 32}}}}};

class ProbeBench {
 public:
  TouchProbe probe{ImagePlace{}, kProbePdos};

  [[nodiscard]] std::uint16_t function() {
    probe.write(outputs_);
    return PdoEntry<std::uint16_t>(2).get(outputs_);
  }
  Phase exchange(std::uint16_t status, bool fresh = true) {
    PdoEntry<std::uint16_t>(0).set(inputs_, status);
    for (std::size_t i = 0; i < 4; ++i)
      PdoEntry<std::int32_t>(2 + 4 * i).set(inputs_, static_cast<std::int32_t>(1000 + i));
    probe.read(inputs_, fresh);
    return probe.phase();
  }

 private:
  std::array<std::byte, 4> outputs_{};
  std::array<std::byte, 18> inputs_{};
};

struct Row {
  ProbeTrigger trigger;
  std::uint16_t function;
  std::uint16_t on;
  std::uint16_t has;
  std::int32_t value;
};

class ProbeTriggers : public testing::TestWithParam<Row> {};

TEST_P(ProbeTriggers, AreArmedAndLatched) {
  const auto& row = GetParam();
  ProbeBench bench;
  EXPECT_EQ(bench.function(), 0);
  EXPECT_TRUE(bench.probe.possible(row.trigger));
  bench.probe.arm(row.trigger);
  const auto on_and_has = static_cast<std::uint16_t>(row.on | row.has);
  EXPECT_EQ(bench.function(), 0) << "what was latched before goes first";
  EXPECT_EQ(bench.exchange(on_and_has), Phase::kClearing);
  EXPECT_EQ(bench.exchange(0, false), Phase::kClearing) << "no exchange";
  EXPECT_EQ(bench.exchange(0), Phase::kArming);
  EXPECT_EQ(bench.function(), row.function);
  EXPECT_EQ(bench.exchange(0), Phase::kArming);
  EXPECT_EQ(bench.exchange(row.on), Phase::kArmed);
  EXPECT_EQ(bench.exchange(static_cast<std::uint16_t>(row.on | ~on_and_has)), Phase::kArmed) << "bits of others";
  EXPECT_EQ(bench.exchange(on_and_has), Phase::kLatched);
  EXPECT_EQ(bench.probe.value(), row.value);
  EXPECT_EQ(bench.function(), row.function);
  bench.probe.disarm();
  EXPECT_EQ(bench.function(), 0);
}

INSTANTIATE_TEST_SUITE_P(Bits, ProbeTriggers,
                         testing::Values(Row{ProbeTrigger::kFirstRising, 0x0011, 0x0001, 0x0002, 1000},
                                         Row{ProbeTrigger::kFirstFalling, 0x0021, 0x0001, 0x0004, 1001},
                                         Row{ProbeTrigger::kSecondRising, 0x1100, 0x0100, 0x0200, 1002},
                                         Row{ProbeTrigger::kSecondFalling, 0x2100, 0x0100, 0x0400, 1003},
                                         Row{ProbeTrigger::kZeroPulse, 0x0015, 0x0001, 0x0002, 1000}));

TEST(ProbeObjects, WhatIsNotMappedIsNotPossible) {
  auto pdos = kProbePdos;
  pdos.inputs.pop_back();
  const TouchProbe probe(ImagePlace{}, pdos);
  EXPECT_TRUE(probe.possible(ProbeTrigger::kFirstFalling));
  EXPECT_FALSE(probe.possible(ProbeTrigger::kSecondRising));
  pdos.outputs.clear();
  EXPECT_FALSE(TouchProbe(ImagePlace{}, pdos).possible(ProbeTrigger::kFirstFalling));
}

}  // namespace
}  // namespace driveline::motion
