#include "driveline/canopen_client/error_history.hpp"
#include "driveline/canopen_client/nmt_commands.hpp"
#include "driveline/canopen_client/scan.hpp"
#include "driveline/canopen_client/sdo_client.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "scripted_port.hpp"
#include "support/canopen_sample.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;

/// A port to a simulated bus in virtual time.
class BusPort final : public CanPort, private slaves::can::Node {
 public:
  BusPort(slaves::can::Bus& bus, rt::VirtualClock& clock) : bus_(&bus), clock_(&clock) { bus.attach(*this); }

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override {
    bus_->advance(clock_->now());
    return controller_->send(frame) ? SendStatus::kSent : SendStatus::kBusy;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    bus_->advance(clock_->now());
    if (received_.empty()) return std::nullopt;
    const auto frame = received_.front();
    received_.pop_front();
    return frame;
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    while (received_.empty() && bus_->now() < deadline) bus_->advance(std::min(deadline, bus_->next_event()));
    clock_->sleep_until(bus_->now());
    return !received_.empty();
  }
  [[nodiscard]] PortStatistics statistics() const noexcept override { return {}; }

 private:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, nanoseconds now) override { received_.push_back({frame, now}); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  slaves::can::Bus* bus_;
  rt::VirtualClock* clock_;
  slaves::can::Controller* controller_ = nullptr;
  std::deque<ReceivedFrame> received_;
};

/// The sample device with node-ID 5, with block transfer.
class SdoDeviceTest : public ::testing::Test {
 protected:
  SdoDeviceTest() {
    bus.attach(device);
    link.set_listener([this](const ReceivedFrame& frame) { states.receive(frame); });
    static_cast<void>(link.receive(5ms));
  }
  static slaves::cia301::DeviceOptions with_blocks() {
    slaves::cia301::DeviceOptions options;
    options.block_transfer = true;
    return options;
  }
  static std::vector<std::byte> long_value() {
    std::vector<std::byte> value(2000);  // its length is fixed
    for (std::size_t i = 0; i < value.size(); ++i) value[i] = static_cast<std::byte>(i * 7U);
    return value;
  }

  rt::VirtualClock clock;
  slaves::can::Bus bus;
  slaves::ObjectDictionary dictionary{slaves::cia301::sample_table()};
  slaves::cia301::SampleApplication application;
  slaves::cia301::Device device{dictionary, application, with_blocks()};
  BusPort port{bus, clock};
  BusLink link{port, clock};
  NodeStates states;
  SdoClient client{link, 5};
};

TEST_F(SdoDeviceTest, ReadsAndWritesInEveryKindOfTransfer) {
  EXPECT_EQ(*must(client.upload_number({0x1000, 0})), 0x0002'0192U);
  EXPECT_EQ(must(client.upload({0x1008, 0}))->size(), 13U);
  EXPECT_TRUE(client.download_number({0x2000, 0}, 0xFFFE, 2));
  EXPECT_EQ(*must(client.upload_number({0x2000, 0})), 0xFFFEU);
  for (const bool block : {false, true}) {
    client.set_options({.block = block});
    ASSERT_TRUE(client.download({0x2008, 0}, long_value()));
    EXPECT_EQ(*must(client.upload({0x2008, 0})), long_value());
    client.set_options({.block = !block});
    EXPECT_EQ(*must(client.upload({0x2008, 0})), long_value());
    ASSERT_TRUE(client.download({0x2008, 0}, hex("01")));
  }
}

TEST_F(SdoDeviceTest, SubBlocksOfOneSegment) {
  client.set_options({.block = true, .block_segments = 1});
  ASSERT_TRUE(client.download({0x2008, 0}, long_value()));
  EXPECT_EQ(*must(client.upload({0x2008, 0})), long_value());
}

TEST_F(SdoDeviceTest, AbortsOfTheDeviceArrive) {
  EXPECT_EQ(client.upload({0x3000, 0}).error().code, SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(client.upload({0x2005, 0}).error().code, SdoAbort::kWriteOnly);
  EXPECT_EQ(client.download_number({0x1000, 0}, 1, 4).error().code, SdoAbort::kReadOnly);
  EXPECT_EQ(client.download_number({0x2000, 0}, 1, 4).error().code, SdoAbort::kLengthTooHigh);
  EXPECT_TRUE(client.upload({0x1000, 0})) << "an abort leaves nothing behind";
}

TEST_F(SdoDeviceTest, ACompletelyLostAnswerEndsOneTransferOnly) {
  bus.inject({slaves::can::FrameFaultKind::kLost, 0x585, Identifier::kBaseMask, 1});
  EXPECT_EQ(client.upload({0x1000, 0}).error().kind, ClientErrorKind::kNoAnswer);
  EXPECT_EQ(*must(client.upload_number({0x1000, 0})), 0x0002'0192U);
}

TEST_F(SdoDeviceTest, NmtCommandsAndStates) {
  EXPECT_EQ(states.of(5).state, NmtState::kPreOperational);
  NmtCommands nmt(link);
  for (const auto& [command, state] : {std::pair{NmtCommand::kStart, NmtState::kOperational},
                                       std::pair{NmtCommand::kEnterPreOperational, NmtState::kPreOperational},
                                       std::pair{NmtCommand::kStop, NmtState::kStopped}}) {
    ASSERT_TRUE(nmt.send(command, 5));
    EXPECT_EQ(must(nmt.guard(5, 100ms))->state, state);
    EXPECT_EQ(states.of(5).state, state);
  }
  EXPECT_EQ(client.upload({0x1000, 0}).error().kind, ClientErrorKind::kNoAnswer) << "no SDO in Stopped";
  ASSERT_TRUE(nmt.reset_node(NmtCommands::kAll));
  static_cast<void>(link.receive(clock.now() + 100ms));
  EXPECT_EQ(states.of(5).boot_ups, 2U);
}

TEST_F(SdoDeviceTest, AScanFindsIt) {
  const auto found = must(Scan(link, {{}, 2ms, 1'000'000}).run());
  ASSERT_EQ(found->size(), 1U);
  EXPECT_EQ(found->front().node, 5);
  EXPECT_EQ(found->front().device_type, 0x0002'0192U);
}

TEST_F(SdoDeviceTest, TheHistoryHasTheNewestErrorFirst) {
  EXPECT_TRUE(must(read_error_history(client))->empty());
  device.raise({0x2310, 0x02, {std::byte{3}, std::byte{1}}}, bus.now());
  device.raise({0x8611, 0x20, {std::byte{17}, std::byte{1}}}, bus.now());
  static_cast<void>(link.receive(clock.now() + 5ms));
  const auto errors = *must(read_error_history(client));
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[0].code, 0x8611);
  EXPECT_EQ(errors[1].code, 0x2310);
}

}  // namespace
}  // namespace driveline::canopen
