#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driveline/snapshot/feed/feed_topic.hpp"

namespace driveline::runtime {

/// Rate at which a topic is published.
struct TopicRate {
  using Kind = snapshot::FeedRateKind;
  Kind kind = Kind::kDefault;          ///< selects which of the next two members applies, if any
  std::uint32_t cycles = 1;            ///< Kind::kCycles: publish every n-th cycle, n = 1 to 1000000
  std::chrono::nanoseconds period{0};  ///< Kind::kPeriod: interval
};

/// A discovery server of Fast DDS.
struct DiscoveryServer {
  std::string address;     ///< IPv4
  std::uint16_t port = 0;  ///< UDP port, 1 to 65535
};

/// A user of this machine.
struct MachineUser {
  std::string name;         ///< name of the user as configured, or the number as text
  std::uint32_t user = 0;   ///< number of the user
  std::uint32_t group = 0;  ///< number of its primary group
};

/// [telemetry] of a line description.
struct TelemetryConfig {
  /// `enabled` in the file; none: left out. If it is true, the run fails when the bridge program is missing.
  std::optional<bool> asked;
  bool enabled = true;                                  ///< false: nothing is sent
  bool service = false;                                 ///< a service starts the bridge, not the run
  std::uint32_t domain = 0;                             ///< DDS domain, 0 to 232
  std::string partition;                                ///< DDS partition of the line; empty: the default one
  std::uint32_t decimation = 8;                         ///< axis samples of every n-th cycle are sent
  std::vector<std::string> interfaces = {"127.0.0.1"};  ///< IPv4 addresses DDS uses; empty: all
  std::vector<std::string> peers;                       ///< IPv4 addresses of machines that multicast does not reach
  /// Server for participant discovery; none: participants discover each other.
  std::optional<DiscoveryServer> discovery_server;
  bool ros2 = false;                                   ///< also the ROS 2 topics joint_states and diagnostics
  bool shared_memory = false;                          ///< also shared memory to subscribers of the bridge's own user
  std::optional<MachineUser> user;                     ///< user of a bridge that root starts; none: the user `nobody`
  std::optional<std::filesystem::path> security;       ///< folder with the files of DDS Security; none: not used
  std::optional<std::filesystem::path> qos_profiles;   ///< Fast DDS profiles for the writers; none: built-in ones
  std::array<TopicRate, snapshot::kFeedTopics> rates;  ///< indexed by snapshot::FeedTopic
};

}  // namespace driveline::runtime
