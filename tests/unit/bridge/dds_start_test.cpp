#include <gmock/gmock.h>

#include <fastdds/dds/log/Log.hpp>
#include <functional>
#include <string>

#include "driveline/bridge/dds_publisher.hpp"
#include "support/must.hpp"

namespace driveline::bridge {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

struct BadConfig {
  std::string name;
  std::function<void(DdsConfig&)> spoil;
  std::string complaint;  ///< must be part of the error
};

std::ostream& operator<<(std::ostream& out, const BadConfig& bad) {
  return out << bad.name;
}

class DdsStartFailure : public testing::TestWithParam<BadConfig> {};

TEST_P(DdsStartFailure, IsOneSentenceThatNamesTheValue) {
  DdsConfig config;
  config.axes = {{.name = "x"}, {.name = "y"}};
  GetParam().spoil(config);
  EXPECT_THAT(failure_text(DdsPublisher::create(config)), AllOf(HasSubstr(GetParam().complaint), EndsWith(".")));
}

INSTANTIATE_TEST_SUITE_P(
    All, DdsStartFailure,
    testing::Values(
        BadConfig{"Domain", [](DdsConfig& c) { c.domain_id = 233; }, "domain 233"},
        BadConfig{"Decimation", [](DdsConfig& c) { c.decimation = 0; }, "decimation is 0"},
        BadConfig{"NoTopic", [](DdsConfig& c) { c.status_topic.clear(); }, "and ''"},
        BadConfig{"SameTopic", [](DdsConfig& c) { c.status_topic = c.axis_topic; }, "two different names"},
        BadConfig{"LongLineName", [](DdsConfig& c) { c.line_name = std::string(32, 'l'); }, "the line has 32 bytes"},
        BadConfig{"LongAxisName", [](DdsConfig& c) { c.axes[1].name = std::string(32, 'a'); }, "axis 1 has 32 bytes"},
        BadConfig{"NoAxisName", [](DdsConfig& c) { c.axes[0].name.clear(); }, "axis 0 has 0 bytes"},
        BadConfig{"InterfaceByName", [](DdsConfig& c) { c.interfaces = {"eth0"}; }, "interface 'eth0'"},
        BadConfig{"PeerByName", [](DdsConfig& c) { c.peers = {"plc.local"}; }, "peer 'plc.local'"},
        BadConfig{"SecureSharedMemory",
                  [](DdsConfig& c) {
                    c.shared_memory = true;
                    c.security = DdsSecurity{};
                  },
                  "not tested with DDS Security"},
        // An address of the documentation range (RFC 5737): valid, but of no interface of this machine.
        BadConfig{"ForeignInterface",
                  [](DdsConfig& c) {
                    c.interfaces = {"127.0.0.1", "203.0.113.77"};
                  },
                  "interface '203.0.113.77'"}),
    [](const auto& tested) { return tested.param.name; });

TEST(DdsStart, AcceptsTheLongestNames) {
  DdsConfig config;
  config.domain_id = 101;
  config.line_name = std::string(31, 'l');
  config.axes = {{.name = std::string(31, 'a')}};
  EXPECT_TRUE(DdsPublisher::create(config));
}

TEST(DdsStart, AProfileLeavesRoomForAllAxes) {
  DdsConfig config;
  config.domain_id = 101;
  config.decimation = 1;
  config.axis_topic = "test/axes_by_profile";
  config.profiles.file = "qos.xml";
  config.profiles.xml =
      "<profiles><data_writer profile_name=\"test/axes_by_profile\"><qos><reliability><kind>RELIABLE</kind>"
      "</reliability></qos></data_writer></profiles>";
  for (int i = 0; i < 12; ++i) config.axes.push_back({.name = "a" + std::to_string(i)});
  const auto publisher = DdsPublisher::create(config);
  ASSERT_TRUE(publisher) << describe(publisher.error());
  for (std::uint16_t axis = 0; axis < 12; ++axis) {
    snapshot::AxisSample sample;
    sample.axis = axis;
    (*publisher)->axes({&sample, 1});
  }
  (*publisher)->pass_done({});
  EXPECT_EQ((*publisher)->counters().published, 12U) << "Fast DDS has room for ten by itself";
  EXPECT_EQ((*publisher)->counters().dropped, 0U);
}

TEST(DdsStart, LeavesStdoutToTheProgram) {
  DdsConfig config;
  config.domain_id = 101;
  ASSERT_TRUE(DdsPublisher::create(config));
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EPROSIMA_LOG_ERROR(BRIDGE_TEST, "a complaint of Fast DDS");
  eprosima::fastdds::dds::Log::Flush();
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("a complaint of Fast DDS"));
}

}  // namespace
}  // namespace driveline::bridge
