#include "line/session.hpp"

#include <gmock/gmock.h>

#include "temporary_directory.hpp"

namespace driveline::cli {
namespace {

using testing::HasSubstr;

class SessionTest : public test::TemporaryDirectory {
 protected:
  Outcome<std::unique_ptr<Session>> open(std::string_view text, BusOptions options = {},
                                         const Session::Adjust& adjust = {}) {
    options.config = directory / "line.toml";
    write(options.config, text);
    return Session::open(options, adjust);
  }
  /// The policy a session would run with; no interface needs to be there.
  rt::RealtimePolicy policy(std::string_view text, const std::string& interface = "") {
    rt::RealtimePolicy policy{};
    BusOptions options;
    options.interface = interface;
    EXPECT_FALSE(open(text, options, [&policy](LineConfig& config) -> Outcome<void> {
      policy = config.realtime.policy;
      return failed("seen");
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

TEST_F(SessionTest, TelemetryOnANetworkInterfaceIsOffUnlessTheFileAsksForIt) {
  const auto enabled = [this](const std::string& telemetry, const std::string& interface) {
    bool on = false;
    BusOptions options;
    options.interface = interface;
    EXPECT_FALSE(open(telemetry + kSlave, options, [&on](LineConfig& config) -> Outcome<void> {
      on = config.telemetry.enabled;
      return failed("seen");
    }));
    return on;
  };
  EXPECT_TRUE(enabled("", ""));
  EXPECT_FALSE(enabled("", "eth7"));
  EXPECT_FALSE(enabled("[bus]\ninterface = \"eth7\"\n", "")) << "also when the file names it";
  EXPECT_FALSE(enabled("[telemetry]\ndomain = 3\n", "eth7")) << "how is not whether";
  EXPECT_TRUE(enabled("[telemetry]\nenabled = true\n", "eth7"));
  EXPECT_FALSE(enabled("[telemetry]\nenabled = false\n", ""));
}

TEST_F(SessionTest, NoBusIsMisuse) {
  const auto session = Session::open({});
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().status, 2);
  EXPECT_THAT(session.error().text, HasSubstr("--config FILE"));
}

TEST_F(SessionTest, InterfaceOfTheFileHasNoVirtualTime) {
  BusOptions options;
  options.virtual_time = true;
  const auto session = open(std::string("[bus]\ninterface = \"eth7\"\n") + kSlave, options);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().status, 2);
  EXPECT_THAT(session.error().text, HasSubstr("no virtual time"));
}

TEST_F(SessionTest, CheckThatFailsComesBeforeAnythingIsOpened) {
  const auto capture = directory / "c.pcapng";
  const auto session = open(kSlave, {}, [&](LineConfig& config) -> Outcome<void> {
    config.output.capture = capture;
    return misused("no");
  });
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().status, 2);
  EXPECT_EQ(session.error().text, "no");
  EXPECT_FALSE(std::filesystem::exists(capture));
}

TEST_F(SessionTest, CaptureThatCannotBeWrittenIsAFailure) {
  const auto session = open(std::string("[output]\ncapture = \"/nowhere/c.pcapng\"\n") + kSlave);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().status, 1);
  EXPECT_THAT(session.error().text, HasSubstr("/nowhere/c.pcapng"));
}

TEST_F(SessionTest, CaptureOfNothingLeavesNoFile) {
  const auto capture = directory / "c.pcapng";
  const auto session = open("[output]\ncapture = \"" + capture.string() + "\"\n" + kSlave);
  ASSERT_TRUE(session) << session.error().text;
  EXPECT_EQ((*session)->close_capture().value(), std::nullopt);
  EXPECT_FALSE(std::filesystem::exists(capture));
}

}  // namespace
}  // namespace driveline::cli
