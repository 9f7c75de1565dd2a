// The cycle in a thread of its own with others beside it: transfers of several threads through the mailboxes and the
// acyclic channel, supervision, commands to the motion. ThreadSanitizer checks this program (.ci/run), so the threads
// synchronise only through the master itself.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/slaves/ethernet_link.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::CyclicCore;
using motion::CycleRunner;
using motion::MotionPhase;

/// Cycles in a thread on the virtual clock while a caller waits for time to pass, so a busy machine only slows down the
/// test.
class ThreadRunner final : public CycleRunner {
 public:
  ThreadRunner(CyclicCore& core, rt::Clock& clock)
      : core_(core), clock_(clock), timer_(clock, core.settings().period), wanted_ns_(clock.now().count()) {}
  ~ThreadRunner() override { stop(); }
  ThreadRunner(const ThreadRunner&) = delete;
  ThreadRunner& operator=(const ThreadRunner&) = delete;

  [[nodiscard]] auto start() -> decltype(std::declval<CycleRunner&>().start()) override {
    timer_.start(core_.first_grid(clock_.now() + timer_.period()));
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
    return {};
  }

  /// Any number of threads.
  void pass(nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    auto wanted_ns = wanted_ns_.load(std::memory_order_relaxed);
    while (wanted_ns < end.count() &&
           !wanted_ns_.compare_exchange_weak(wanted_ns, end.count(), std::memory_order_relaxed)) {
    }
    while (clock_.now() < end) std::this_thread::yield();
  }

  void stop() override {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(const std::stop_token& stop) noexcept {
    while (!stop.stop_requested()) {
      // Relaxed, so that waiting does not synchronise memory.
      if (clock_.now().count() >= wanted_ns_.load(std::memory_order_relaxed)) {
        std::this_thread::yield();
        continue;
      }
      core_.cycle(timer_.wait_next());
      timer_.shift_phase(core_.grid_shift());
    }
  }

  CyclicCore& core_;
  rt::Clock& clock_;
  rt::CycleTimer timer_;
  std::atomic<nanoseconds::rep> wanted_ns_;
  std::jthread thread_;
};

/// On the path, or on the way back to its start, because it is repeated.
bool under_way(MotionPhase phase) {
  return phase == MotionPhase::kFollowing || phase == MotionPhase::kApproach;
}

/// Writes and reads an object of a slave; returns how often the value matched.
int transfers(ecat_master::MailboxEngine& engine, std::uint16_t slave, std::uint32_t first, int count) {
  int right = 0;
  for (int i = 0; i < count; ++i) {
    CoeClient coe(engine, slave);
    const auto value = first + static_cast<std::uint32_t>(i);
    if (!coe.download_as<std::uint32_t>(0x6065, 0, value)) continue;
    const auto read = coe.upload_as<std::uint32_t>(0x6065, 0);
    if (read && *read == value) ++right;
  }
  return right;
}

/// Measures for how long the machine lets a thread wait, on the real clock.
class Standstill {
 public:
  [[nodiscard]] nanoseconds longest() const { return nanoseconds{longest_ns_.load()}; }

 private:
  void watch(const std::stop_token& stop) {
    const rt::MonotonicClock clock;
    for (auto before = clock.now(); !stop.stop_requested();) {
      std::this_thread::sleep_for(milliseconds{5});
      const auto now = clock.now();
      longest_ns_ = std::max(longest_ns_.load(), (now - before).count());
      before = now;
    }
  }

  std::atomic<nanoseconds::rep> longest_ns_{0};
  std::jthread thread_{[this](const std::stop_token& stop) { watch(stop); }};
};

struct SerialsRead {
  std::string start;           ///< what went wrong before the threads began
  std::array<int, 8> right{};  ///< by thread: how often it read the right serial number
};

/// Lets each thread read fifty serial numbers. On the real clock: a waiting thread drives the engine for the others.
SerialsRead read_serials() {
  rt::MonotonicClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> made;
  for (std::uint32_t i = 0; i < 4; ++i) {
    slaves::msd::MsdParameters parameters;
    parameters.serial_number = 1000 + i;
    made.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>(parameters)));
  }
  slaves::SimulatedLine drives(clock, std::move(made));
  ecat_master::Master master(drives, clock);
  SerialsRead read;
  read.start = sentence(master.scan());
  if (read.start.empty()) read.start = sentence(master.enter_pre_op());
  if (!read.start.empty()) return read;
  std::vector<std::jthread> threads;
  for (std::uint16_t i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      for (int n = 0; n < 50; ++n) {
        const auto slave = static_cast<std::uint16_t>((i + n) % 4);
        const auto serial = CoeClient(master.mailboxes(), slave).upload_as<std::uint32_t>(0x1018, 4);
        if (serial && *serial == 1000U + slave) ++read.right[i];
      }
    });
  }
  threads.clear();
  return read;
}

TEST(SdoFromSeveralThreads, AllGetTheirAnswers) {
  // Answers are late where the machine stands still for about as long as a master waits for them.
  constexpr auto kAboutATimeout = std::chrono::seconds{1};
  for (int left = 3; left >= 0; --left) {
    const Standstill standstill;
    const auto read = read_serials();
    if (left > 0 && standstill.longest() > kAboutATimeout) continue;
    EXPECT_EQ(read.start, "");
    EXPECT_THAT(read.right, testing::Each(50));
    break;
  }
}

TEST(CycleInItsThread, CarriesTransfersOfOthersWhileTheAxesMove) {
  constexpr int kTransfers = 30;
  DriveLine drives(3);
  ConfiguredOperation operation(drives, RunOptions{.repeat = true});
  operation.start_cycle([&](CyclicCore& core) { return std::make_unique<ThreadRunner>(core, drives.clock); });
  auto& master = operation.master();
  ASSERT_EQ(sentence(master.go_operational()), "");
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));

  // A thread for each of three slaves; this thread, the master's, supervises meanwhile.
  std::array<std::atomic<int>, 3> right{};
  std::atomic<int> running{3};
  std::vector<std::jthread> threads;
  for (std::uint16_t slave = 0; slave < 3; ++slave) {
    threads.emplace_back([&, slave] {
      right[slave] = transfers(master.mailboxes(), slave, 1'000'000U * (slave + 1U), kTransfers);
      --running;
    });
  }
  auto& core = *master.core();
  ecat_master::CyclicEvent event;
  motion::MasterAbsence absence;
  while (running.load() > 0) {
    operation.run(milliseconds{1});
    EXPECT_EQ(sentence(master.al_status()), "");
    while (core.take_event(event) || core.take_absence(absence)) {
    }
    for (std::size_t slave = 0; slave < 3; ++slave) EXPECT_TRUE(core.slave_report(slave).operational);
    EXPECT_EQ(core.bad_cycles(), 0U);
    EXPECT_TRUE(under_way(operation.motion().phase()));
  }
  threads.clear();
  for (const auto& count : right) EXPECT_EQ(count, kTransfers);

  operation.motion().request_stop();
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{5}));
  master.runner()->stop();
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
  EXPECT_FALSE(operation.axis_samples.empty());
}

/// The path leaves the software limits, so each start fails when the axes have been enabled.
TEST(CycleInItsThread, AFailureIsCompleteForThoseWhoReadItMeanwhile) {
  using motion::MotionFailure;
  DriveLine drives(1);
  RunOptions options;
  options.software_limits = trajectory::PositionRange{-0.5, 0.5};
  ConfiguredOperation operation(drives, options);
  operation.start_cycle([&](CyclicCore& core) { return std::make_unique<ThreadRunner>(core, drives.clock); });
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  auto& motion = operation.motion();
  std::atomic<int> incomplete{0};
  std::jthread reader([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const auto failure = motion.failure();
      if (failure.cause == MotionFailure::Cause::kOutsideRange && std::abs(failure.reaches) <= 0.5) ++incomplete;
      if (failure.cause == MotionFailure::Cause::kNone && std::abs(failure.reaches) > 0.0) ++incomplete;
    }
  });
  for (int start = 0; start < 3; ++start) {
    motion.request_start();
    operation.run(milliseconds{1});
    EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{5}));
    EXPECT_EQ(motion.failure().cause, MotionFailure::Cause::kOutsideRange);
  }
  reader.request_stop();
  reader.join();
  EXPECT_EQ(incomplete.load(), 0);
  operation.master().runner()->stop();
}

/// A thread that waits for a slave knows nothing of the start of the cycle, nor of its end.
TEST(CycleInItsThread, IsStartedAndEndedWhileOthersReadTheTime) {
  DriveLine drives(1);
  ConfiguredOperation operation(drives);
  auto& exchange = operation.master().bus().exchange();
  std::jthread reader([&](const std::stop_token& stop) {
    for (auto before = exchange.now(); !stop.stop_requested();) {
      const auto now = exchange.now();
      EXPECT_GE(now, before);
      before = now;
    }
  });
  operation.start_cycle([&](CyclicCore& core) { return std::make_unique<ThreadRunner>(core, drives.clock); });
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
}

/// The network behind a drive: returns the last received frame. Used only by the thread of the cycle.
struct Mirror final : slaves::EthernetLink {
  bool send(std::span<const std::byte> frame) noexcept override {
    size = frame.size();
    std::copy(frame.begin(), frame.end(), bytes.begin());
    return true;
  }
  std::size_t receive(std::span<std::byte> out) noexcept override {
    std::copy_n(bytes.begin(), size, out.begin());
    return std::exchange(size, 0);
  }
  void set_address(const wire::EoeIpParameters& /*address*/) noexcept override {}
  void set_link(bool /*up*/) noexcept override {}

  std::array<std::byte, wire::kMaxEoeFrame> bytes{};
  std::size_t size = 0;
};

/// Counts the returned frames, from any thread.
struct Counter final : ecat_master::EoeReceiver {
  void receive(std::uint16_t /*position*/, std::span<const std::byte> frame) override {
    right += frame.size() == 1000 && frame[999] == std::byte{0x5A} ? 1 : 0;
    ++all;
  }
  int right = 0;
  std::atomic<int> all{0};
};

TEST(CycleInItsThread, CarriesEthernetFramesBesideTransfers) {
  constexpr int kFrames = 40;
  DriveLine drives(2);
  ConfiguredOperation operation(drives);
  std::array<Mirror, 2> mirrors;
  Counter counter;
  std::vector<std::shared_ptr<ecat_master::EoePort>> ports;
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(drives.slave(i).device().connect_network(&mirrors[i]));
    ports.push_back(operation.master().open_eoe(i, counter).value());
  }
  operation.start_cycle([&](CyclicCore& core) { return std::make_unique<ThreadRunner>(core, drives.clock); });
  auto& master = operation.master();
  ASSERT_EQ(sentence(master.go_operational()), "");

  // One thread submits frames, one steps the mailboxes, one transfers objects.
  int right = 0;
  std::jthread sender([&] {
    const std::vector<std::byte> frame(1000, std::byte{0x5A});
    for (int sent = 0; sent < kFrames; ++sent) {
      for (auto& port : ports) ASSERT_TRUE(port->send(frame));
      while (counter.all.load() < 2 * (sent + 1)) std::this_thread::yield();
    }
  });
  std::jthread stepper([&] {
    while (counter.all.load() < 2 * kFrames) master.mailboxes().drive();
  });
  std::jthread transferrer([&] { right = transfers(master.mailboxes(), 1, 1'000'000, 20); });
  sender.join();
  stepper.join();
  transferrer.join();
  EXPECT_EQ(right, 20);
  EXPECT_EQ(counter.right, 2 * kFrames);
  for (const auto& port : ports) EXPECT_EQ(port->statistics().frames_out, static_cast<std::uint64_t>(kFrames));
  master.runner()->stop();
}

}  // namespace
}  // namespace driveline::bus_test
