// Clocks that follow an external time: steered, jumping, shared by several lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "clock_run.hpp"
#include "true_time.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::dc::FollowMode;
using ecat_master::dc::SystemTimeSource;
using ecat_master::dc::TimeSource;

/// An external time far from the master's, disciplined: 80 ppm fast for three seconds, then 40 ppm slow. The same
/// function of time for all callers.
class SteeredTime final : public TimeSource {
 public:
  explicit SteeredTime(const rt::Clock& clock) : clock_(clock) {}
  [[nodiscard]] nanoseconds now() const noexcept override { return at(clock_.now()); }
  [[nodiscard]] nanoseconds at(nanoseconds time) const noexcept {
    const auto fast = std::min(time, kTurn);
    const auto slow = std::max(time - kTurn, nanoseconds{0});
    const double gained = 80e-6 * static_cast<double>(fast.count()) - 40e-6 * static_cast<double>(slow.count());
    return kOrigin + time + nanoseconds{std::llround(gained)} + jump;
  }
  nanoseconds jump{0};

 private:
  static constexpr nanoseconds kTurn = seconds{3};
  static constexpr nanoseconds kOrigin = seconds{848'000'000};  // in 2026
  const rt::Clock& clock_;
};

/// A line whose reference clock follows a steered time.
struct SteeredLine {
  explicit SteeredLine(unsigned seed) : line(random_clocks(4, 60.0, seed), std::nullopt, cables()), time(line.clock) {}
  static slaves::LineOptions cables() {
    slaves::LineOptions options;
    options.cable_delay = nanoseconds{50};
    return options;
  }
  std::string start() {
    auto plan = line.plan();
    plan.mode = FollowMode::kReferenceFollows;
    plan.time = &time;
    return run.start(plan);
  }
  /// Lead of the reference clock over the time that it follows.
  nanoseconds ahead() { return ahead_of(line.system_time(0), static_cast<std::uint64_t>(time.now().count())); }

  ClockLine line;
  SteeredTime time;
  ClockRun run{line};
};

TEST(ClockTime, TheReferenceFollowsATimeThatIsSteered) {
  SteeredLine steered(1);
  ASSERT_EQ(steered.start(), "");
  steered.run.run(milliseconds{500});
  nanoseconds worst{0};
  nanoseconds arrival{0};
  nanoseconds apart{0};
  // Includes the change from 80 ppm fast to 40 ppm slow.
  steered.run.run(seconds{5}, [&] {
    worst = std::max(worst, std::chrono::abs(steered.ahead()));
    arrival = std::max(arrival, std::chrono::abs(steered.run.arrival_error()));
    apart = std::max(apart, steered.run.worst_sync0());
  });
  // The clock lags by the delay of the frame, which cannot be measured from one end, and while it learns the new speed.
  EXPECT_LE(worst, microseconds{3});
  EXPECT_LE(arrival, microseconds{2}) << "the cycle keeps its phase";
  // While the reference clock changes its speed by 120 ppm at once, much more than a steered clock does.
  EXPECT_LE(apart, microseconds{4});
  EXPECT_TRUE(steered.run.status().locked);
  EXPECT_EQ(steered.run.status().unlocks, 0U);
  EXPECT_LE(steered.run.worst_sync0(), nanoseconds{40});
}

/// Two lines with their own clocks and masters, and one common time.
TEST(ClockTime, TwoLinesThatFollowItKeepOneTime) {
  SteeredLine one(1);
  SteeredLine other(7);
  ASSERT_EQ(one.start(), "");
  ASSERT_EQ(other.start(), "");
  for (auto* line : {&one, &other}) line->run.run(seconds{6} - line->line.clock.now());
  nanoseconds least = seconds{1};
  nanoseconds most = -seconds{1};
  for (auto* line : {&one, &other}) {
    line->run.run(seconds{1}, [&] {
      least = std::min(least, line->ahead());
      most = std::max(most, line->ahead());
    });
  }
  EXPECT_LE(most - least, nanoseconds{200}) << "the two reference clocks against the common time";
  // SYNC0 is at multiples of the period of that time, on both lines.
  for (auto* line : {&one, &other}) {
    const auto start = line->run.master().clocks()->start;
    EXPECT_EQ(start % 125'000U, 0U);
  }
}

TEST(ClockTime, AJumpIsToldAndNotFollowed) {
  SteeredLine steered(3);
  ASSERT_EQ(steered.start(), "");
  steered.run.run(seconds{1});
  static_cast<void>(steered.run.events());
  const auto before = steered.ahead();
  steered.time.jump = seconds{1};
  nanoseconds apart{0};
  steered.run.run(seconds{1}, [&] { apart = std::max(apart, steered.run.worst_sync0()); });
  EXPECT_THAT(steered.run.events(),
              testing::ElementsAre(testing::MatchesRegex(
                  "the time source of the clocks has jumped by 10000000[0-9][0-9] ns; they have not")));
  EXPECT_LE(std::chrono::abs(steered.ahead() + seconds{1} - before), microseconds{2});
  EXPECT_LE(apart, nanoseconds{100});
  EXPECT_TRUE(steered.run.status().locked);
  EXPECT_EQ(steered.run.status().unlocks, 0U);
}

TEST(ClockTime, WhoLeadsShowsItFromTheStartAndThenItsOwn) {
  ClockLine line(random_clocks(3, 60.0));
  const SteeredTime time(line.clock);
  ClockRun run(line);
  auto plan = line.plan();
  plan.time = &time;
  ASSERT_EQ(run.start(plan), "");
  const auto ahead = [&] { return ahead_of(line.system_time(0), static_cast<std::uint64_t>(time.now().count())); };
  // Half a second at a difference of up to 140 ppm.
  EXPECT_LE(std::chrono::abs(ahead()), microseconds{100});
  const auto then = ahead();
  run.run(seconds{1});
  EXPECT_GT(std::chrono::abs(ahead() - then), microseconds{5}) << "it is not followed";
}

TEST(ClockTime, TheMachinesTimeCountsFrom2000) {
  // `date -d 2000-01-01T00:00:00Z +%s`
  constexpr seconds kUnixTimeOf2000{946'684'800};
  // Not std::time(): it reads the clock of the kernel's last tick, up to 10 ms in the past.
  const auto since_2000 = [&] { return std::chrono::system_clock::now().time_since_epoch() - kUnixTimeOf2000; };
  const SystemTimeSource utc(SystemTimeSource::Scale::kUtc);
  const auto before = since_2000();
  const auto now = utc.now();
  EXPECT_GE(now, before);
  EXPECT_LE(now, since_2000());
  const SystemTimeSource tai(SystemTimeSource::Scale::kTai);
  EXPECT_GE(tai.now(), now) << "TAI is ahead, or the kernel does not know by how much";
}

TEST(ClockTime, BothClocksAreReadTogether) {
  rt::VirtualClock clock(seconds{5});
  const SteeredTime time(clock);
  const auto both = ecat_master::dc::read_both(time, [&] { return clock.now(); });
  EXPECT_EQ(both.local, seconds{5});
  EXPECT_EQ(both.external, time.at(seconds{5}));
}

}  // namespace
}  // namespace driveline::bus_test
