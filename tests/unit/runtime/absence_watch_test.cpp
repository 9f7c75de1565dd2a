#include "bus/absence_watch.hpp"

#include <gmock/gmock.h>

#include <deque>
#include <string>
#include <vector>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {
namespace {

using motion::AbsenceEffect;
using motion::MasterAbsence;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using testing::ElementsAre;
using testing::IsEmpty;

class AbsenceWatchTest : public testing::Test {
 protected:
  static constexpr nanoseconds kBegin = std::chrono::seconds{100};

  void away(nanoseconds since, nanoseconds duration, AbsenceEffect effect = AbsenceEffect::kBridged,
            nanoseconds path_late = nanoseconds{0}) {
    absences.push_back({kBegin + since, duration, path_late, 0, effect});
  }
  AbsenceWatch make() {
    return {[this](MasterAbsence& absence) {
              if (absences.empty()) return false;
              absence = absences.front();
              absences.pop_front();
              return true;
            },
            kBegin};
  }
  static std::string sentence(const MasterAbsence& absence) {
    return describe(Event{events::MasterAway{absence, {8, {}}}});
  }
  static std::vector<std::string> sentences(const std::vector<MasterAbsence>& all) {
    std::vector<std::string> told;
    for (const auto& absence : all) told.push_back(sentence(absence));
    return told;
  }

  std::deque<MasterAbsence> absences;
};

TEST_F(AbsenceWatchTest, TellsWhenHowLongAndHowLateThePathIs) {
  away(milliseconds{-500}, milliseconds{3});
  auto watch = make();
  EXPECT_THAT(watch.poll().bridged, IsEmpty()) << "what was before the operation is no news";
  away(milliseconds{850}, milliseconds{54}, AbsenceEffect::kBridged, milliseconds{54});
  away(milliseconds{1200}, nanoseconds{140'000}, AbsenceEffect::kNone);
  const auto found = watch.poll();
  EXPECT_THAT(sentences(found.bridged),
              ElementsAre("the master was away for 54.0 ms at 0.850 s; the path is 54.0 ms late",
                          "the master was away for 0.1 ms at 1.200 s"));
  EXPECT_FALSE(found.stopped);
  EXPECT_FALSE(watch.rest(0));
}

TEST_F(AbsenceWatchTest, NamesTheOneThatStoppedTheAxes) {
  auto watch = make();
  away(milliseconds{850}, milliseconds{54}, AbsenceEffect::kStopped);
  const auto found = watch.poll();
  EXPECT_THAT(found.bridged, IsEmpty());
  ASSERT_TRUE(found.stopped);
  EXPECT_EQ(sentence(*found.stopped),
            "the master was away for 54.0 ms at 0.850 s, longer than the 8 cycles that [bus] max_lost_cycles allows: "
            "all axes stopped");
}

TEST_F(AbsenceWatchTest, IsTheCauseOfWhatComesShortlyAfter) {
  auto watch = make();
  EXPECT_FALSE(watch.cause_of(kBegin));
  away(milliseconds{850}, milliseconds{54});
  away(milliseconds{906}, milliseconds{1});
  static_cast<void>(watch.poll());
  EXPECT_FALSE(watch.cause_of(kBegin + milliseconds{849})) << "before";
  for (const auto after : {milliseconds{870}, milliseconds{1200}}) {
    const auto cause = watch.cause_of(kBegin + after);
    ASSERT_TRUE(cause) << "a watchdog, meanwhile";
    EXPECT_EQ(cause->since, milliseconds{850});
    EXPECT_EQ(cause->duration, milliseconds{54});
  }
  EXPECT_FALSE(watch.cause_of(kBegin + milliseconds{1300})) << "long after";
}

TEST_F(AbsenceWatchTest, OfManyTellsTheFirstThoseThatAreLongerAndTheSumOfTheRest) {
  auto watch = make();
  std::size_t told = 0;
  for (int i = 0; i < 50; ++i) {
    away(milliseconds{10 * i}, milliseconds{i == 40 ? 7 : 1});
    told += watch.poll().bridged.size();
  }
  EXPECT_EQ(told, AbsenceWatch::kReportedSingly + 1) << "the longest is among them";
  const auto rest = watch.rest(2);
  ASSERT_TRUE(rest);
  EXPECT_EQ(describe(Event{*rest}), "the master was away 31 more times, 29.0 ms in all, 1.0 ms at the longest");
}

}  // namespace
}  // namespace driveline::runtime
