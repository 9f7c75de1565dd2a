// An adversary between master and line inserts thousands of the master's own frames, randomly changed, between the good
// ones. Whatever they do to the slaves, there is no lasting damage: no answer of another length, time advances, and
// after a power cycle a new start succeeds. Seeded; with sanitizers every memory access is checked.
#include <gtest/gtest.h>

#include "drive_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using Bytes = std::vector<std::byte>;

/// Linear congruential generator (Numerical Recipes); its upper bits are good enough here.
class Random {
 public:
  explicit Random(std::uint32_t seed) : state_(seed) {}
  std::uint32_t below(std::size_t limit) {
    state_ = state_ * 1664525U + 1013904223U;
    return static_cast<std::uint32_t>((std::uint64_t{state_} * limit) >> 32);
  }

 private:
  std::uint32_t state_;
};

/// Everything the master sends from discovery to motion, SDO transfers and shut-down.
std::vector<Bytes> own_traffic() {
  std::vector<Bytes> frames;
  DriveLine drives(3);
  ChangingPort recorder(drives.line(),
                        [&](std::span<std::byte> frame) { frames.emplace_back(frame.begin(), frame.end()); }, {});
  LineOperation operation(drives, recorder);
  EXPECT_EQ(sentence(operation.to_motion()), "");
  operation.run(milliseconds{20});
  ecat_master::CoeClient coe(*operation.master().mailbox(1));
  EXPECT_EQ(sentence(coe.upload(0x1008, 0)), "");
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
  return frames;
}

void mutate(Bytes& frame, Random& random) {
  const unsigned changes = 1 + random.below(8);
  for (unsigned i = 0; i < changes && !frame.empty(); ++i) {
    // Headers are most sensitive: commands, addresses, lengths, the more bit.
    const std::size_t at =
        random.below(3) != 0 ? random.below(std::min<std::size_t>(frame.size(), 48)) : random.below(frame.size());
    switch (random.below(6)) {
      case 0:
        frame[at] ^= std::byte{1} << random.below(8);
        break;
      case 1:
        frame[at] = std::byte{0xFF};
        break;
      case 2:
        frame[at] = std::byte{0};
        break;
      case 3:
        frame.resize(random.below(frame.size() + 1));
        break;
      case 4:
        frame.resize(std::min<std::size_t>(frame.size() + random.below(300), port::kMaxFrameBytes), std::byte{0xA5});
        break;
      default:
        frame[at] = static_cast<std::byte>(random.below(256));
        break;
    }
  }
}

/// Sends a frame past the master and takes its reply, if any, from the line; it must have the same length.
void inject(slaves::SimulatedLine& line, rt::VirtualClock& clock, Bytes frame) {
  const auto length = frame.size();
  const auto before = clock.now();
  line.process(frame, clock.now());
  EXPECT_EQ(frame.size(), length);
  EXPECT_EQ(clock.now(), before) << "a frame does not hold up time";
}

void power_cycle(DriveLine& drives) {
  for (std::size_t i = 0; i < drives.size(); ++i) {
    drives.line().set_power(i, false);
    drives.line().set_power(i, true);
  }
  drives.leave_alone(milliseconds{1});
}

class Adversary : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Adversary, ChangedFramesOfOurOwnBreakNothingForGood) {
  static const auto kTraffic = own_traffic();
  ASSERT_GT(kTraffic.size(), 400U);
  Random random(GetParam());
  DriveLine drives(3);
  auto& line = drives.line();
  for (int i = 0; i < 4000; ++i) {
    auto frame = kTraffic[random.below(kTraffic.size())];
    if (random.below(4) != 0) mutate(frame, random);
    inject(line, drives.clock, std::move(frame));
    if (random.below(8) == 0) drives.leave_alone(microseconds{random.below(3000)});
    if (random.below(500) == 0) drives.leave_alone(milliseconds{random.below(400)});
  }
  EXPECT_GT(line.counters().malformed, 100U);
  EXPECT_GT(line.counters().frames, 3999U);
  power_cycle(drives);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.to_motion()), "");
  EXPECT_TRUE(operation.run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{3}));
}

TEST_P(Adversary, ChangedFramesBetweenGoodOnesEndInAnErrorOrNot) {
  static const auto kTraffic = own_traffic();
  constexpr int kStarts = 20;
  Random random(GetParam() + 1000);
  DriveLine drives(3);
  unsigned injected = 0;
  ChangingPort port(drives.line(),
                    [&](std::span<std::byte>) {
                      if (random.below(50) != 0) return;
                      auto frame = kTraffic[random.below(kTraffic.size())];
                      mutate(frame, random);
                      inject(drives.line(), drives.clock, std::move(frame));
                      ++injected;
                    },
                    {});
  for (int start = 0; start < kStarts; ++start) {
    LineOperation operation(drives, port);
    // The master succeeds or reports the reason; it neither hangs nor reports success for garbage.
    const auto begin = drives.clock.now();
    const auto done = operation.to_op();
    if (done) {
      operation.run(milliseconds{5});
    } else {
      EXPECT_NE(sentence(done), "");
    }
    EXPECT_LT(drives.clock.now() - begin, std::chrono::seconds{60});
    static_cast<void>(operation.master().shut_down());
    power_cycle(drives);
  }
  EXPECT_GT(injected, 50U);
  LineOperation again(drives);
  EXPECT_EQ(sentence(again.to_op()), "");
}

INSTANTIATE_TEST_SUITE_P(Seeds, Adversary, testing::Range(1U, 9U));

}  // namespace
}  // namespace driveline::bus_test
