// Authority over the axes: which caller may command an axis.
#include "driveline/runtime/axes/axis_authority.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;
using testing::ElementsAre;
using testing::IsEmpty;

LeaseTerms terms(std::string owner, std::optional<nanoseconds> until = std::nullopt) {
  LeaseTerms terms;
  terms.owner = std::move(owner);
  terms.until = until;
  return terms;
}

TEST(AxisAuthority, OneAtATime) {
  AxisAuthority authority(2);
  EXPECT_EQ(authority.owner_of(0), "");
  ASSERT_TRUE(authority.take(0, terms("hand")));
  const auto refused = authority.take(0, terms("stream"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().owner, "hand");
  EXPECT_FALSE(refused.error().firm);
  EXPECT_TRUE(authority.take(0, terms("hand"))) << "his own again";
  EXPECT_TRUE(authority.take(1, terms("stream"))) << "each axis by itself";
  EXPECT_TRUE(authority.holds(0, "hand"));
  EXPECT_FALSE(authority.holds(0, "stream"));
}

TEST(AxisAuthority, NumbersOfLeasesAreNotThoseOfAnEarlierRun) {
  AxisAuthority before(2);
  const auto first = before.take(0, terms("hand"));
  const auto second = before.take(1, terms("hand"));
  ASSERT_TRUE(first && second);
  EXPECT_GT(*second, *first);
  std::this_thread::sleep_for(std::chrono::milliseconds{2});
  AxisAuthority after(1);
  const auto later = must(after.take(0, terms("hand")));
  EXPECT_GT(*later, *second);
}

TEST(AxisAuthority, WhatCouldBeHadIsToldWithoutTakingIt) {
  AxisAuthority authority(2);
  EXPECT_TRUE(authority.check(0, terms("hand")));
  EXPECT_EQ(authority.owner_of(0), "");
  ASSERT_TRUE(authority.take(0, terms("hand")));
  const auto refused = authority.check(0, terms("stream"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().owner, "hand");
  auto taking = terms("stream");
  taking.take_over = true;
  EXPECT_TRUE(authority.check(0, taking));
  EXPECT_EQ(authority.owner_of(0), "hand");
  EXPECT_THAT(authority.losses(nanoseconds{0}), IsEmpty());
  auto firm = terms("path");
  firm.firm = true;
  ASSERT_TRUE(authority.take(1, firm));
  EXPECT_TRUE(authority.check(1, taking).error().firm);
}

TEST(AxisAuthority, WhatIsGivenBackCanBeHad) {
  AxisAuthority authority(3);
  ASSERT_TRUE(authority.take(0, terms("hand")));
  ASSERT_TRUE(authority.take(2, terms("hand")));
  authority.release(0, "stream");
  EXPECT_EQ(authority.owner_of(0), "hand") << "nobody gives away what is another's";
  authority.release(0, "hand");
  EXPECT_TRUE(authority.take(0, terms("stream")));
  EXPECT_THAT(authority.release_all("hand"), ElementsAre(2U));
  EXPECT_THAT(authority.losses(nanoseconds{0}), IsEmpty()) << "what is given back is not lost";
}

TEST(AxisAuthority, EveryChangeOfHandsIsKnownInOrder) {
  using Kind = LeaseChange::Kind;
  AxisAuthority authority(2);
  ASSERT_TRUE(authority.take(1, terms("stream")));
  ASSERT_TRUE(authority.take(1, terms("stream"))) << "no change";
  EXPECT_FALSE(authority.take(1, terms("hand"))) << "none either";
  auto takes_over = terms("hand", nanoseconds{100});
  takes_over.take_over = true;
  ASSERT_TRUE(authority.take(1, takes_over));
  static_cast<void>(authority.losses(nanoseconds{100}));
  ASSERT_TRUE(authority.take(0, terms("path")));
  static_cast<void>(authority.release_all("path"));
  authority.release(0, "path");
  std::vector<std::tuple<std::size_t, Kind, std::string, std::string>> seen;
  for (const auto& change : authority.take_changes())
    seen.emplace_back(change.axis, change.kind, change.owner, change.before);
  EXPECT_THAT(seen,
              ElementsAre(std::tuple(1, Kind::kTaken, "stream", ""), std::tuple(1, Kind::kTakenOver, "hand", "stream"),
                          std::tuple(1, Kind::kExpired, "", "hand"), std::tuple(0, Kind::kTaken, "path", ""),
                          std::tuple(0, Kind::kReleased, "", "path")));
  EXPECT_THAT(authority.take_changes(), IsEmpty());
}

TEST(AxisAuthority, WhoLosesItToAnotherIsToldOnce) {
  AxisAuthority authority(1);
  ASSERT_TRUE(authority.take(0, terms("stream")));
  auto takes_over = terms("hand");
  takes_over.take_over = true;
  ASSERT_TRUE(authority.take(0, takes_over));
  const auto lost = authority.losses(nanoseconds{0});
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].owner, "stream");
  EXPECT_EQ(lost[0].taken_by, "hand");
  EXPECT_THAT(authority.losses(nanoseconds{0}), IsEmpty());
  ASSERT_TRUE(authority.take(0, takes_over));
  EXPECT_THAT(authority.losses(nanoseconds{0}), IsEmpty()) << "nobody loses an axis to himself";
}

TEST(AxisAuthority, NobodyTakesOverFromWhatMovesTheAxesForGood) {
  AxisAuthority authority(1);
  auto path = terms("path");
  path.firm = true;
  ASSERT_TRUE(authority.take(0, path));
  auto takes_over = terms("hand");
  takes_over.take_over = true;
  const auto refused = authority.take(0, takes_over);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().owner, "path");
  EXPECT_TRUE(refused.error().firm);
}

TEST(AxisAuthority, ANamesakeNeitherChangesNorEndsAFirmLease) {
  AxisAuthority authority(1);
  auto path = terms("path");
  path.firm = true;
  const auto number = must(authority.take(0, path));
  const auto refused = authority.take(0, terms("path", nanoseconds{100}));
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().firm);
  authority.release(0, "path");
  EXPECT_THAT(authority.release_all("path"), IsEmpty());
  EXPECT_THAT(authority.losses(nanoseconds{100}), IsEmpty());
  EXPECT_TRUE(authority.goes_on(0, *number));
  EXPECT_EQ(authority.take(0, path).value(), *number) << "the source itself keeps its lease";
}

TEST(AxisAuthority, EachLeaseHasANumberOfItsOwn) {
  AxisAuthority authority(2);
  EXPECT_FALSE(authority.goes_on(0, 0)) << "nobody's";
  const auto first = must(authority.take(0, terms("stream")));
  EXPECT_TRUE(authority.goes_on(0, *first));
  EXPECT_FALSE(authority.goes_on(1, *first));
  EXPECT_EQ(authority.take(0, terms("stream")).value_or(0), *first) << "prolonged";
  authority.release(0, "stream");
  EXPECT_FALSE(authority.goes_on(0, *first));
  const auto second = must(authority.take(0, terms("stream")));
  EXPECT_NE(*second, *first);
  auto takes_over = terms("hand", nanoseconds{100});
  takes_over.take_over = true;
  const auto third = must(authority.take(0, takes_over));
  EXPECT_FALSE(authority.goes_on(0, *second));
  EXPECT_EQ(authority.losses(nanoseconds{100}).size(), 2U);
  EXPECT_FALSE(authority.goes_on(0, *third));
}

TEST(AxisAuthority, LeaseThatIsNotProlongedEnds) {
  AxisAuthority authority(2);
  ASSERT_TRUE(authority.take(0, terms("hand", nanoseconds{100})));
  ASSERT_TRUE(authority.take(1, terms("stream")));
  EXPECT_THAT(authority.losses(nanoseconds{99}), IsEmpty());
  authority.prolong("hand", nanoseconds{200});
  EXPECT_THAT(authority.losses(nanoseconds{199}), IsEmpty());
  ASSERT_TRUE(authority.take(0, terms("hand", nanoseconds{100})));
  authority.prolong("hand", std::nullopt);
  EXPECT_THAT(authority.losses(nanoseconds{1'000}), IsEmpty()) << "no end any more";
  ASSERT_TRUE(authority.take(0, terms("hand", nanoseconds{200})));
  const auto lost = authority.losses(nanoseconds{200});
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].axis, 0U);
  EXPECT_EQ(lost[0].owner, "hand");
  EXPECT_EQ(lost[0].taken_by, "");
  EXPECT_TRUE(authority.take(0, terms("other")));
  authority.prolong("hand", nanoseconds{300});
  EXPECT_EQ(authority.owner_of(0), "other");
  EXPECT_EQ(authority.owner_of(1), "stream") << "without an end it goes on";
}

}  // namespace
}  // namespace driveline::runtime
