// Frames of other senders that come without end.
#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <utility>
#include <vector>

#include "driveline/ecat_master/bus/direct_exchange.hpp"
#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/port/redundant_port.hpp"
#include "support/fake_port.hpp"

namespace driveline::ecat_master {
namespace {

using ecat_master_test::answered;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

/// A minimum frame at 1 Gbit/s.
constexpr nanoseconds kMinimumFrame{670};

/// Delivers `first` foreign frames, then the answers to what was sent, then foreign frames again. Each frame takes
/// `each`.
class FloodPort final : public port::Port {
 public:
  FloodPort(rt::VirtualClock& clock, nanoseconds each, std::uint64_t first)
      : clock_(clock), each_(each), first_(first) {
    foreign_[7] = std::byte{8};  // another FrameTag::instance
    foreign_[12] = std::byte{0x88};
    foreign_[13] = std::byte{0xA4};
  }
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    answers_.push_back(answered(frame, std::byte{0x08}));
    return port::SendStatus::kSent;
  }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    clock_.advance(each_);
    if (received_++ < first_ || answers_.empty()) return port::ReceivedFrame{foreign_, clock_.now()};
    held_ = std::move(answers_.front());
    answers_.pop_front();
    return port::ReceivedFrame{held_, clock_.now()};
  }
  bool wait_readable(nanoseconds) noexcept override { return true; }
  [[nodiscard]] nanoseconds last_send_time() const noexcept override { return clock_.now(); }
  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }

  /// Marks the foreign frames as copies of a ring, which the redundant port drops.
  void mark_as_copies() noexcept { foreign_[6] |= std::byte{0x04}; }

 private:
  rt::VirtualClock& clock_;
  nanoseconds each_;
  std::uint64_t first_;
  std::uint64_t received_ = 0;
  std::array<std::byte, 60> foreign_{};
  std::deque<std::vector<std::byte>> answers_;
  std::vector<std::byte> held_;
};

constexpr std::uint64_t kNoAnswer = ~std::uint64_t{0};

TEST(Flood, ACycleEndsSoonAfterItsDeadline) {
  for (const auto receive : {ReceiveStrategy::kSpin, ReceiveStrategy::kSleep, ReceiveStrategy::kBlock}) {
    rt::VirtualClock clock;
    FloodPort port(clock, kMinimumFrame, kNoAnswer);
    CyclicCore::Settings settings;
    settings.receive = receive;
    CyclicCore core(port, clock, ProcessImage{}, nullptr, {}, settings);
    const auto grid = clock.now();
    core.cycle({0, grid, grid, 0});
    EXPECT_LE(clock.now() - grid, settings.receive_window + microseconds{10});
    EXPECT_EQ(core.statistics().flooded_cycles, 1U);
    EXPECT_EQ(core.flooded_cycles(), 1U);
    EXPECT_EQ(core.statistics().foreign_frames, port.received()) << "all are counted";
  }
}

TEST(Flood, ACycleTakesNoMoreThanItsShareHoweverFastTheFramesAre) {
  rt::VirtualClock clock;
  FloodPort port(clock, nanoseconds{0}, kNoAnswer);
  CyclicCore core(port, clock, ProcessImage{}, nullptr, {}, {});
  for (std::uint64_t cycle = 1; cycle <= 3; ++cycle) {
    core.cycle({static_cast<std::int64_t>(cycle), clock.now(), clock.now(), 0});
    EXPECT_EQ(port.received(), 256 * cycle);
    EXPECT_EQ(core.statistics().flooded_cycles, cycle);
    EXPECT_EQ(core.statistics().lost_frames, cycle);
  }
}

TEST(Flood, AnAnswerBehindSomeForeignFramesIsTaken) {
  // 100 frames pass within the window of 90 us; of a slow port, five frames are left after it.
  for (const auto& [first, each] : {std::pair{100, kMinimumFrame}, std::pair{5, nanoseconds{microseconds{100}}}}) {
    rt::VirtualClock clock;
    FloodPort port(clock, each, static_cast<std::uint64_t>(first));
    CyclicCore core(port, clock, ProcessImage{}, nullptr, {}, {});
    core.cycle({0, clock.now(), clock.now(), 0});
    EXPECT_EQ(core.statistics().lost_frames, 0U) << first;
    EXPECT_EQ(core.statistics().flooded_cycles, 0U) << first;
  }
}

TEST(Flood, ACycleOnARingEndsAsWell) {
  for (const bool copies : {false, true}) {
    rt::VirtualClock clock;
    FloodPort primary(clock, kMinimumFrame, kNoAnswer);
    FloodPort secondary(clock, kMinimumFrame, kNoAnswer);
    if (copies) {
      primary.mark_as_copies();
      secondary.mark_as_copies();
    }
    port::RedundantPort ring(primary, secondary, clock);
    CyclicCore core(ring, clock, ProcessImage{}, nullptr, {}, {});
    const auto grid = clock.now();
    core.cycle({0, grid, grid, 0});
    EXPECT_LE(clock.now() - grid, microseconds{150}) << "copies " << copies;
    EXPECT_EQ(ring.wait_readable(clock.now()), !copies) << "the instant has passed";
  }
}

TEST(Flood, AnExchangeEndsWithItsTimeout) {
  rt::VirtualClock clock;
  FloodPort port(clock, microseconds{10}, kNoAnswer);
  DirectExchange exchange(port, clock, {.retries = 1});
  std::array<std::byte, 2> data{};
  std::vector<Request> requests{{wire::Command::kFprd, wire::DatagramAddress::physical(0x1001, 0x0130), data}};
  const auto begin = clock.now();
  EXPECT_FALSE(exchange.exchange(requests));
  EXPECT_LT(clock.now() - begin, std::chrono::milliseconds{11}) << "2 ms, then four times as long";
  EXPECT_EQ(exchange.statistics().floods, 2U);
}

TEST(Flood, AnExchangeEndsThoughTimeStandsStill) {
  rt::VirtualClock clock;
  FloodPort port(clock, nanoseconds{0}, kNoAnswer);
  DirectExchange exchange(port, clock, {.retries = 0});
  std::array<std::byte, 2> data{};
  std::vector<Request> requests{{wire::Command::kFprd, wire::DatagramAddress::physical(0x1001, 0x0130), data}};
  EXPECT_FALSE(exchange.exchange(requests));
  EXPECT_EQ(port.received(), DirectExchange::kMostUnexpected);
}

}  // namespace
}  // namespace driveline::ecat_master
