// Reading a drive through its mailbox: alone on the line, and beside a master.
#include <gmock/gmock.h>

#include "driveline/wire/registers.hpp"
#include "line/drive_link.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using testing::HasSubstr;
using wire::AlState;

/// A simulated line in this process, and another master on it.
class DriveLinkTest : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    test::TemporaryDirectory::SetUp();
    const auto file = directory / "line.toml";
    write(file,
          "[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\nmodel = \"servoone\"\n"
          "[[slave]]\nname = \"box\"\nesi = \"" DRIVELINE_EXAMPLES_DIR "/terminals.xml\"\ndevice = \"MX4\"\n");
    runtime::BusOptions options;
    options.config = file.string();
    options.virtual_time = true;
    auto session = must(runtime::Session::open(options));
    session_ = std::move(*session);
    other_ = std::make_unique<ecat_master::Master>(session_->port(), session_->clock());
  }

  /// The other master takes all slaves to PREOP.
  void take_line() {
    ASSERT_TRUE(other_->scan());
    ASSERT_TRUE(other_->enter_pre_op());
  }
  [[nodiscard]] std::vector<AlState> states() {
    std::vector<AlState> states;
    const auto reports = other_->peek_states();
    if (reports) {
      for (const auto& report : *reports) states.push_back(report.status.state);
    }
    return states;
  }

  std::unique_ptr<runtime::Session> session_;
  std::unique_ptr<ecat_master::Master> other_;
};

TEST_F(DriveLinkTest, TakesALineInInitToPreOpAndBack) {
  {
    auto link = must(DriveLink::open(*session_));
    EXPECT_FALSE((*link)->other_master());
    EXPECT_EQ((*link)->size(), 3U);
    DriveView view;
    ASSERT_TRUE((*link)->read(0, view)) << view.trouble;
    EXPECT_EQ(view.al.status.state, AlState::kPreOp);
    EXPECT_EQ(view.values.text(DriveObject::kAlias), "x");
    EXPECT_EQ(view.values.number(DriveObject::kStatusWord), 0x0250);
    EXPECT_EQ(view.values.number(DriveObject::kReferenceCycle), 1.0);
    EXPECT_EQ(view.values.number(DriveObject::kPeriodIndex), -3.0);
    ASSERT_TRUE((*link)->read(1, view)) << view.trouble;
    EXPECT_EQ(view.values.text(DriveObject::kDeviceName), "ServoOne");
  }
  EXPECT_THAT(states(), testing::Each(AlState::kInit));
}

TEST(DriveLinkOfSeveralDrives, ReadsTheObjectsOfTheOneThatIsChosen) {
  runtime::BusOptions bus;
  bus.config = std::string(DRIVELINE_EXAMPLES_DIR) + "/dual_drive.toml";
  bus.virtual_time = true;
  const auto session = must(runtime::Session::open(bus));
  auto link = must(DriveLink::open(**session));
  for (const auto& [drive, exists] : {std::pair{0U, true}, std::pair{1U, true}, std::pair{2U, false}}) {
    DriveView view;
    view.drive = drive;
    ASSERT_TRUE((*link)->read(0, view)) << view.trouble;
    EXPECT_EQ(view.values.number(DriveObject::kStatusWord).has_value(), exists) << drive;
    EXPECT_EQ(view.values.number(DriveObject::kDeviceType), 0x00020192);
  }
}

TEST_F(DriveLinkTest, LeavesTheStatesOfAnotherMasterAlone) {
  take_line();
  const std::vector<AlState> before = states();
  {
    auto link = must(DriveLink::open(*session_));
    EXPECT_TRUE((*link)->other_master());
    DriveView view;
    for (int i = 0; i < 20; ++i) {
      ASSERT_TRUE((*link)->read(0, view)) << view.trouble;
      // The other master's own transfers continue meanwhile.
      ecat_master::CoeClient coe(*other_->mailbox(0));
      ASSERT_EQ(coe.upload_as<std::uint16_t>(0x6041, 0).value(), 0x0250);
    }
    EXPECT_TRUE(view.other_master);
  }
  EXPECT_EQ(states(), before);
}

TEST_F(DriveLinkTest, SeesWhatChanges) {
  take_line();
  auto link = must(DriveLink::open(*session_));
  DriveView view;
  ASSERT_TRUE((*link)->read(0, view));
  EXPECT_EQ(view.values.number(DriveObject::kMode), 0.0);
  ecat_master::CoeClient coe(*other_->mailbox(0));
  ASSERT_TRUE(coe.download_as<std::int8_t>(0x6060, 0, 8));
  ASSERT_TRUE((*link)->read(0, view));
  EXPECT_EQ(view.values.number(DriveObject::kMode), 8.0);
}

/// MSD manual 13.2, the fifth method: the PC software, whose role the page of a drive plays here.
TEST_F(DriveLinkTest, Way5ThePcToolAcknowledgesAFault) {
  take_line();
  auto link = must(DriveLink::open(*session_));
  ecat_master::CoeClient coe(*other_->mailbox(0));
  // An inconsistent data set: fault 02 05.
  ASSERT_TRUE(coe.download_as<std::uint8_t>(0x200B, 4, 1));
  ASSERT_TRUE(coe.download_as<std::int32_t>(0x607D, 1, 5000));
  ASSERT_TRUE(coe.download_as<std::uint8_t>(0x200B, 4, 0));
  DriveView view;
  ASSERT_TRUE((*link)->read(0, view));
  EXPECT_EQ(view.values.number(DriveObject::kErrorCode), 0x6320);
  ASSERT_TRUE((*link)->acknowledge(0));
  ASSERT_TRUE((*link)->read(0, view));
  EXPECT_EQ(view.values.number(DriveObject::kErrorCode), 0x6320) << "its cause lasts";
  ASSERT_TRUE(coe.download_as<std::int32_t>(0x607D, 1, 0));
  ASSERT_TRUE((*link)->acknowledge(0));
  ASSERT_TRUE((*link)->read(0, view));
  EXPECT_EQ(view.values.number(DriveObject::kErrorCode), 0.0);
  EXPECT_EQ(static_cast<unsigned>(*view.values.number(DriveObject::kStatusWord)) & 0x4FU, 0x40U);
}

TEST_F(DriveLinkTest, WhatHasNoParameterForItCannotAcknowledge) {
  auto link = must(DriveLink::open(*session_));
  DriveView view;
  EXPECT_FALSE((*link)->read(2, view));
  const auto done = (*link)->acknowledge(2);
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().text, HasSubstr("slave 2 has no parameter P 153 (2099h)"));
}

TEST_F(DriveLinkTest, ASlaveInInitIsLeftToItsMaster) {
  take_line();
  const auto slave = other_->slaves()[0].info.ref;
  ASSERT_TRUE(ecat_master::change_state(other_->bus(), std::span(&slave, 1), AlState::kInit, std::chrono::seconds{1}));
  auto link = must(DriveLink::open(*session_));
  DriveView view;
  EXPECT_FALSE((*link)->read(0, view));
  EXPECT_THAT(view.trouble, HasSubstr("slave 0 is in INIT, in which it has no CoE mailbox; another master"));
  EXPECT_EQ(states()[0], AlState::kInit);
  EXPECT_TRUE((*link)->read(1, view)) << "its neighbour can be looked at";
}

TEST_F(DriveLinkTest, ComesBackWhenTheSlaveDoes) {
  take_line();
  auto link = must(DriveLink::open(*session_));
  DriveView view;
  ASSERT_TRUE((*link)->read(0, view));
  const auto slave = other_->slaves()[0].info.ref;
  ASSERT_TRUE(ecat_master::change_state(other_->bus(), std::span(&slave, 1), AlState::kInit, std::chrono::seconds{1}));
  EXPECT_FALSE((*link)->read(0, view));
  EXPECT_EQ(view.values.text(DriveObject::kAlias), "x") << "values of before";
  take_line();
  EXPECT_TRUE((*link)->read(0, view)) << view.trouble;
  EXPECT_EQ(view.trouble, "");
}

/// A run that ends with a fault leaves the line in INIT; the page then shows the present values of the drive.
TEST_F(DriveLinkTest, ShowsTheDriveAsItIsWhenItsMasterHasLeftTheLineInInit) {
  take_line();
  {
    auto link = must(DriveLink::open(*session_));
    DriveView view;
    ASSERT_TRUE((*link)->read(0, view));
    EXPECT_EQ(view.values.number(DriveObject::kErrorCode), 0.0);
    ecat_master::CoeClient coe(*other_->mailbox(0));
    ASSERT_TRUE(coe.download_as<std::uint8_t>(0x200B, 4, 1));
    ASSERT_TRUE(coe.download_as<std::int32_t>(0x607D, 1, 5000));
    ASSERT_TRUE(coe.download_as<std::uint8_t>(0x200B, 4, 0));  // fault 02 05
    ASSERT_TRUE(other_->shut_down());
    EXPECT_FALSE((*link)->read(0, view)) << "a master that starts is given a second";
    EXPECT_THAT(view.trouble, HasSubstr("is in INIT"));
    EXPECT_THAT(states(), testing::Each(AlState::kInit));
    session_->clock().sleep_until(session_->clock().now() + std::chrono::milliseconds{1100});
    ASSERT_TRUE((*link)->read(0, view)) << view.trouble;
    EXPECT_EQ(view.trouble, "");
    EXPECT_EQ(view.al.status.state, AlState::kPreOp);
    EXPECT_EQ(view.values.number(DriveObject::kErrorCode), 0x6320);
    EXPECT_EQ(static_cast<unsigned>(*view.values.number(DriveObject::kStatusWord)) & 0x4FU, 0x08U) << "fault";
    EXPECT_FALSE(view.other_master);
    EXPECT_FALSE((*link)->other_master());
  }
  EXPECT_THAT(states(), testing::Each(AlState::kInit)) << "and leaves the line as it was";
}

TEST_F(DriveLinkTest, WhatIsNoDriveIsNamed) {
  auto link = must(DriveLink::open(*session_));
  DriveView view;
  const auto done = (*link)->read(2, view);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().status, 1);
  EXPECT_THAT(done.error().text, HasSubstr("slave 2 is not a servo drive: its device type 1000h is 0x00001389"));
}

TEST_F(DriveLinkTest, StationAddressesOfAnotherMasterAreNotTouched) {
  take_line();
  const auto lost = other_->slaves()[1].info.ref;
  const auto kept = other_->slaves()[0].info.ref;
  ASSERT_TRUE(other_->bus().write(lost, wire::reg::kStationAddress, 0));
  auto link = must(DriveLink::open(*session_));
  DriveView view;
  EXPECT_FALSE((*link)->read(1, view));
  EXPECT_THAT(view.trouble, HasSubstr("no unique station address"));
  EXPECT_TRUE((*link)->read(0, view)) << view.trouble;
  EXPECT_EQ(other_->bus().read(kept, wire::reg::kStationAddress).value(), kept.station);
  std::array<std::byte, 2> station{};
  EXPECT_EQ(other_->bus().try_read(lost, wire::reg::kStationAddress.address, station).value(), false)
      << "it still has none";
}

}  // namespace
}  // namespace driveline::cli
