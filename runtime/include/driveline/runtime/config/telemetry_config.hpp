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

/// How often a topic is published.
struct TopicRate {
  using Kind = snapshot::FeedRateKind;
  Kind kind = Kind::kDefault;          ///< which of the next two counts, if any
  std::uint32_t cycles = 1;            ///< of Kind::kCycles: n, 1 to 1000000
  std::chrono::nanoseconds period{0};  ///< of Kind::kPeriod
};

/// A discovery server of Fast DDS.
struct DiscoveryServer {
  std::string address;     ///< IPv4
  std::uint16_t port = 0;  ///< of UDP, 1 to 65535
};

/// A user of this machine.
struct MachineUser {
  std::string name;         ///< as configured: of the user, or its number
  std::uint32_t user = 0;   ///< its number
  std::uint32_t group = 0;  ///< number of its primary group
};

/// [telemetry] of a line description.
struct TelemetryConfig {
  /// `enabled` of the file; none: it is left out. A run that was asked for telemetry does not begin without.
  std::optional<bool> asked;
  bool enabled = true;                                  ///< false: nothing is sent
  bool service = false;                                 ///< a service starts the bridge, not the run
  std::uint32_t domain = 0;                             ///< DDS domain, 0 to 232
  std::string partition;                                ///< DDS partition of the line; empty: the default one
  std::uint32_t decimation = 8;                         ///< axis samples of every n-th cycle are sent
  std::vector<std::string> interfaces = {"127.0.0.1"};  ///< IPv4 addresses DDS uses; empty: all
  std::vector<std::string> peers;                       ///< IPv4 addresses of machines that no multicast reaches
  std::optional<DiscoveryServer> discovery_server;      ///< who tells who is there; none: they find each other
  bool ros2 = false;                                    ///< also the ROS 2 topics joint_states and diagnostics
  bool shared_memory = false;                           ///< also to subscribers of the bridge's own user
  std::optional<MachineUser> user;                      ///< whom the bridge of a root becomes; none: nobody
  std::optional<std::filesystem::path> security;        ///< folder with the files of DDS Security; none: without
  std::optional<std::filesystem::path> qos_profiles;    ///< profiles of Fast DDS for the writers; none: their own
  std::array<TopicRate, snapshot::kFeedTopics> rates;   ///< by snapshot::FeedTopic
};

}  // namespace driveline::runtime
