// Slaves that may be missing when the line starts, and join it during operation.
#include <gmock/gmock.h>

#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "edited_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineSupervisor;
using ecat_master::SlavePlan;
using wire::AlState;

constexpr std::uint16_t kAlias = 0x0207;
constexpr std::uint16_t kDeviceId = 712;
constexpr std::size_t kProductByte = 20;  // words 10 and 11 of the EEPROM

/// Three drives, the last of them hot-connected and without supply.
class HotConnected : public testing::Test {
 protected:
  void start(const EditedLine::Edit& edit, const std::function<void(SlavePlan&)>& last) {
    line = std::make_unique<EditedLine>(3, edit);
    line->line().set_power(2, false);
    std::vector<SlavePlan> plans;
    for (std::size_t i = 0; i < 3; ++i) plans.push_back(LineOperation::plan(i, RunOptions{}));
    plans[2].hot_connect = true;
    last(plans[2]);
    master = std::make_unique<ecat_master::Master>(line->line(), line->clock);
    ASSERT_EQ(sentence(master->scan()), "");
    ASSERT_EQ(sentence(master->configure(plans)), "");
    ecat_master::CyclicCore::Settings settings;
    const auto started = master->start_cycle(nullptr, {}, settings, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, line->clock);
    });
    ASSERT_TRUE(started.has_value());
    ASSERT_EQ(sentence(master->go_operational()), "");
    supervisor = std::make_unique<LineSupervisor>(*master);
    master->core()->count(false);
    master->pass(milliseconds{1});
    master->core()->count(true);
  }
  void live(nanoseconds duration) {
    const auto end = line->clock.now() + duration;
    while (line->clock.now() < end) {
      master->pass(milliseconds{5});
      supervisor->poll();
      longest_bad = std::max(longest_bad, master->core()->bad_cycles());
    }
  }
  bool live_until_it_is_there() {
    const auto end = line->clock.now() + std::chrono::seconds{5};
    while (!supervisor->operational(2) && line->clock.now() < end) live(milliseconds{20});
    live(milliseconds{10});
    return supervisor->operational(2) && line->slave(2).state() == AlState::kOp;
  }
  std::string told() const {
    std::string all;
    for (const auto& event : supervisor->history()) all += what_happened(event) + "\n";
    return all;
  }
  /// Expects the same as if all three had been present from the start.
  void expect_complete() {
    const auto& group = master->core()->groups()[0];
    std::uint32_t expected = 0;
    for (const auto& datagram : master->image().datagrams()) expected += datagram.expected_working_counter;
    EXPECT_EQ(group.working_counter.load(), expected);
    EXPECT_TRUE(master->core()->slave_report(2).valid);
    ecat_master::CoeClient coe(*master->mailbox(2));
    EXPECT_EQ(sentence(coe.upload(0x1008, 0)), "");
    EXPECT_EQ(master->slaves()[2].info.description.serial_number, 1002U) << "what it says, not one of its kind";
  }
  /// No slave lost a cycle, and no cycle counted as bad.
  void expect_undisturbed() {
    EXPECT_EQ(longest_bad, 0U);
    EXPECT_EQ(master->core()->statistics().wkc_errors, 0U);
    EXPECT_EQ(master->core()->statistics().lost_frames, 0U);
  }

  std::unique_ptr<EditedLine> line;
  std::unique_ptr<ecat_master::Master> master;
  std::unique_ptr<LineSupervisor> supervisor;
  std::uint32_t longest_bad = 0;
};

void with_alias(std::size_t drive, slaves::DeviceProfile& profile) {
  if (drive == 2) set_alias(profile, kAlias);
}

TEST_F(HotConnected, JoinsByItsAlias) {
  start(with_alias, [](SlavePlan& plan) { plan.alias = kAlias; });
  ASSERT_EQ(master->slaves().size(), 3U);
  EXPECT_FALSE(master->slaves()[2].present);
  EXPECT_EQ(master->position_of(2), 2U);
  live(milliseconds{300});
  EXPECT_TRUE(supervisor->all_operational()) << "nobody waits for it";
  EXPECT_EQ(told(), "");
  line->line().set_power(2, true);
  ASSERT_TRUE(live_until_it_is_there()) << told();
  EXPECT_EQ(told(), "slave 2: joined the line and is in OP\n");
  expect_complete();
  expect_undisturbed();
  EXPECT_EQ(sentence(master->shut_down()), "");
  EXPECT_EQ(line->slave(2).state(), AlState::kInit);
}

TEST_F(HotConnected, JoinsByItsDeviceId) {
  start([](std::size_t drive, auto& profile) { profile.device_id = static_cast<std::uint16_t>(710 + drive); },
        [](SlavePlan& plan) { plan.device_id = kDeviceId; });
  live(milliseconds{300});
  EXPECT_EQ(told(), "");
  line->line().set_power(2, true);
  ASSERT_TRUE(live_until_it_is_there()) << told();
  EXPECT_EQ(told(), "slave 2: joined the line and is in OP\n");
  expect_complete();
  expect_undisturbed();
}

TEST_F(HotConnected, GoesAndComesAgain) {
  start(with_alias, [](SlavePlan& plan) { plan.alias = kAlias; });
  line->line().set_power(2, true);
  ASSERT_TRUE(live_until_it_is_there()) << told();
  for (int round = 0; round < 3; ++round) {
    line->line().set_power(2, false);
    live(milliseconds{100});
    EXPECT_FALSE(supervisor->operational(2));
    line->line().set_power(2, true);
    ASSERT_TRUE(live_until_it_is_there()) << told();
  }
  EXPECT_EQ(supervisor->recoveries(), 3U);
  expect_complete();
  line->line().set_power(2, false);
  EXPECT_EQ(sentence(master->shut_down()), "") << "whoever may go may be gone";
}

TEST_F(HotConnected, MayStayAway) {
  start(with_alias, [](SlavePlan& plan) { plan.alias = kAlias; });
  live(milliseconds{500});
  const auto states = master->al_status();
  ASSERT_EQ(sentence(states), "");
  ASSERT_EQ(states->size(), 3U);
  EXPECT_EQ((*states)[1].status.state, AlState::kOp);
  EXPECT_EQ((*states)[2].status.state, AlState::kNone);
  expect_undisturbed();
  EXPECT_EQ(sentence(master->shut_down()), "");
}

TEST_F(HotConnected, AStrangerWithItsAliasIsNamedAndLeftAlone) {
  start(with_alias, [](SlavePlan& plan) {
    plan.alias = kAlias;
    plan.serial = ecat_master::IdentityRule::equal(4711);
  });
  line->line().set_power(2, true);
  live(std::chrono::seconds{1});
  EXPECT_EQ(told(),
            "slave 2: not brought back to OP: slave 2: serial number is 0x000003EA but 0x00001267 is planned\n");
  EXPECT_EQ(line->slave(2).state(), AlState::kInit);
  expect_undisturbed();
}

TEST_F(HotConnected, WithAnotherAliasItStaysOutside) {
  start(with_alias, [](SlavePlan& plan) { plan.alias = kAlias + 1; });
  line->line().set_power(2, true);
  live(std::chrono::seconds{1});
  EXPECT_EQ(told(), "");
  EXPECT_EQ(line->slave(2).state(), AlState::kInit);
  expect_undisturbed();
}

TEST_F(HotConnected, NeedsNoneOfItsKindToBeThere) {
  start(
      [](std::size_t drive, auto& profile) {
        with_alias(drive, profile);
        if (drive == 2) profile.sii_image[kProductByte] ^= std::byte{0x40};
      },
      [](SlavePlan& plan) {
        plan.alias = kAlias;
        plan.product_code ^= 0x40;
      });
  EXPECT_TRUE(master->slaves()[2].info.sii.empty());
  live(milliseconds{300});
  line->line().set_power(2, true);
  ASSERT_TRUE(live_until_it_is_there()) << told();
  expect_complete();
  expect_undisturbed();
}

TEST_F(HotConnected, WithoutANameItMustBeThere) {
  EditedLine two(2);
  ScannedMaster alone(two.line(), two.clock);
  std::vector<SlavePlan> plans(3);
  plans[2].hot_connect = true;
  EXPECT_THAT(sentence(alone.configure(plans)), testing::HasSubstr("3"));
}

}  // namespace
}  // namespace driveline::bus_test
