#include "driveline/runtime/setup/session.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <vector>

#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using testing::HasSubstr;

class SessionTest : public test::TemporaryDirectory {
 protected:
  Result<std::unique_ptr<Session>> open(std::string_view text, BusOptions options = {},
                                        const Session::Adjust& adjust = {}) {
    options.config = directory / "line.toml";
    write(options.config, text);
    return Session::open(options, adjust);
  }
  /// The policy that a session would run with; the interface need not exist.
  rt::RealtimePolicy policy(std::string_view text, const std::string& interface = "") {
    rt::RealtimePolicy policy{};
    BusOptions options;
    options.interface = interface;
    EXPECT_FALSE(open(text, options, [&policy](LineConfig& config) -> Result<void> {
      policy = config.realtime.policy;
      return fail(ErrorKind::kMachine, "seen");
    }));
    return policy;
  }
};

constexpr auto kSlave = "[[slave]]\nname = \"x\"\n";

TEST_F(SessionTest, RealtimeIsEnforcedWhereverThereIsANetworkInterface) {
  EXPECT_EQ(policy(kSlave), rt::RealtimePolicy::kDegrade);
  EXPECT_EQ(policy(kSlave, "eth7"), rt::RealtimePolicy::kEnforce) << "also when it comes from the command line";
  EXPECT_EQ(policy(std::string("[bus]\ninterface = \"eth7\"\n") + kSlave), rt::RealtimePolicy::kEnforce);
  EXPECT_EQ(policy(std::string("[realtime]\npolicy = \"degrade\"\n") + kSlave, "eth7"), rt::RealtimePolicy::kDegrade);
  EXPECT_EQ(policy(std::string("[realtime]\npolicy = \"enforce\"\n") + kSlave), rt::RealtimePolicy::kEnforce);
}

TEST_F(SessionTest, TelemetryIsOnUnlessTheFileSaysOtherwise) {
  const auto enabled = [this](const std::string& telemetry, const std::string& interface) {
    bool on = false;
    BusOptions options;
    options.interface = interface;
    EXPECT_FALSE(open(telemetry + kSlave, options, [&on](LineConfig& config) -> Result<void> {
      on = config.telemetry.enabled;
      return fail(ErrorKind::kMachine, "seen");
    }));
    return on;
  };
  EXPECT_TRUE(enabled("", ""));
  EXPECT_TRUE(enabled("", "eth7")) << "also on a network interface: nothing of DDS is in this process";
  EXPECT_TRUE(enabled("[bus]\ninterface = \"eth7\"\n", ""));
  EXPECT_TRUE(enabled("[telemetry]\nenabled = true\n", "eth7"));
  EXPECT_FALSE(enabled("[telemetry]\nenabled = false\n", ""));
  EXPECT_FALSE(enabled("[telemetry]\nenabled = false\n", "eth7"));
}

TEST_F(SessionTest, NoBusIsMisuse) {
  const auto session = Session::open({});
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().kind, ErrorKind::kCall);
  EXPECT_THAT(describe(session.error()), HasSubstr("a line description, a network interface, or both"));
}

TEST_F(SessionTest, OrdersToTheLineInThisProcessAreCarriedOutWithTheNextFrame) {
  BusOptions options;
  options.virtual_time = true;
  const auto session = must(open(std::string(kSlave) + "[[slave]]\nname = \"y\"\n", options));
  auto& orders = *(*session)->line_orders();
  LineOrder order;
  order.fault = {.kind = slaves::FaultKind::kPowerOff, .slave = 1};
  order.number = 7;
  ASSERT_TRUE(orders.order(order));
  LineOrder answer;
  EXPECT_FALSE(orders.next_answer(answer)) << "nothing has run the line";
  EXPECT_TRUE((*session)->simulated_line()->slave(1).powered());
  std::array<std::byte, 60> frame{};
  static_cast<void>((*session)->port().send(frame));
  ASSERT_TRUE(orders.next_answer(answer));
  EXPECT_TRUE(answer.done);
  EXPECT_EQ(answer.number, 7U);
  EXPECT_FALSE((*session)->simulated_line()->slave(1).powered());
  order.verb = LineOrder::Verb::kReportStates;
  ASSERT_TRUE(orders.order(order));
  static_cast<void>((*session)->port().send(frame));
  StateChange change;
  std::vector<std::uint16_t> off;
  while (orders.next_change(change)) {
    if (change.status.state == wire::AlState::kNone) off.push_back(change.slave);
  }
  EXPECT_EQ(off, (std::vector<std::uint16_t>{1}));
}

TEST_F(SessionTest, InterfaceOfTheFileHasNoVirtualTime) {
  BusOptions options;
  options.virtual_time = true;
  const auto session = open(std::string("[bus]\ninterface = \"eth7\"\n") + kSlave, options);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().kind, ErrorKind::kSetting);
  EXPECT_THAT(describe(session.error()), HasSubstr("no virtual time"));
}

TEST_F(SessionTest, CheckThatFailsComesBeforeAnythingIsOpened) {
  const auto capture = directory / "c.pcapng";
  const auto session = open(kSlave, {}, [&](LineConfig& config) -> Result<void> {
    config.output.capture = capture;
    return fail(ErrorKind::kSetting, "no");
  });
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().kind, ErrorKind::kSetting);
  EXPECT_EQ(describe(session.error()), "no");
  EXPECT_FALSE(std::filesystem::exists(capture));
}

TEST_F(SessionTest, CaptureThatCannotBeWrittenIsAFailure) {
  const auto session = open(std::string("[output]\ncapture = \"/nowhere/c.pcapng\"\n") + kSlave);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().kind, ErrorKind::kMachine);
  EXPECT_THAT(describe(session.error()), HasSubstr("/nowhere/c.pcapng"));
}

TEST_F(SessionTest, CaptureOfNothingLeavesNoFile) {
  const auto capture = directory / "c.pcapng";
  const auto session = must(open("[output]\ncapture = \"" + capture.string() + "\"\n" + kSlave));
  EXPECT_EQ((*session)->close_capture().value().file, std::nullopt);
  EXPECT_FALSE(std::filesystem::exists(capture));
}

}  // namespace
}  // namespace driveline::runtime
