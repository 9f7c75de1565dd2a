#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace driveline::bridge {

/// Kind of an axis; determines the units of its telemetry.
enum class AxisKind : std::uint8_t {
  kRotary,  ///< rad, rad/s, Nm
  kLinear,  ///< m, m/s, N
};

/// Name and kind of an axis, as subscribers see them.
struct AxisInfo {
  std::string name;                   ///< 1 to 31 bytes
  AxisKind kind = AxisKind::kRotary;  ///< unit of its samples: rad or m
};

/// Longest name of an axis or a line, in bytes (the bound in the IDL).
inline constexpr std::size_t kMaxNameLength = 31;

/// Files of DDS Security (OMG DDS Security 1.1, 8.3 and 8.4) that define the identity of this participant, whom it
/// trusts, and the permissions. Other participants of the domain without such files, or without permission, receive
/// nothing.
struct DdsSecurity {
  std::string identity_ca;     ///< certificate of the authority that signs identities, PEM
  std::string certificate;     ///< own identity, PEM
  std::string private_key;     ///< private key of the identity, PEM
  std::string permissions_ca;  ///< certificate of the authority that signs the next two files, PEM
  std::string governance;      ///< rules of the domain, signed
  std::string permissions;     ///< permissions of this participant, signed
};

/// Selection of the axis samples that a topic publishes.
struct SampleRate {
  std::uint32_t cycles = 1;  ///< publish the cycles whose number is a multiple; at least 1
  /// Publish a selected sample only if anything but cycle and time has changed, and at least one per second.
  bool on_change = false;
};

/// Address of a discovery server of Fast DDS, which announces all its clients to each other.
struct DdsDiscoveryServer {
  std::string address;     ///< IPv4
  std::uint16_t port = 0;  ///< UDP port; the GUID prefix is that of server 0, 44.53.00.5f.45.50.52.4f.53.49.4d.41
};

/// Fast DDS profiles for writers; the name of a profile is the name of its topic.
struct DdsProfiles {
  std::string xml;   ///< content of the file; empty: no profiles
  std::string file;  ///< name of the file in messages
};

/// Settings of a DdsPublisher.
struct DdsConfig {
  std::uint32_t domain_id = 0;                 ///< 0 to 232; above 100 its ports overlap Linux's ephemeral ports
  std::string participant_name = "driveline";  ///< shown by DDS tools
  std::string line_name = "line";              ///< 1 to 31 bytes
  std::vector<AxisInfo> axes;                  ///< by axis index; samples of other axes are refused and counted
  std::string axis_topic = "driveline/axis_telemetry";  ///< name of the DDS topic of the axis samples; empty: none
  std::string status_topic = "driveline/line_status";   ///< name of the DDS topic of the line's status
  /// Name of the DDS topic of batches: all axes in every cycle. Empty: none.
  std::string batch_topic = "driveline/v1/axis_batch";
  std::string event_topic = "driveline/v1/event";        ///< name of the DDS topic of events; empty: none
  std::string slave_topic = "driveline/v1/slave";        ///< name of the DDS topic of the slaves; empty: none
  std::string topology_topic = "driveline/v1/topology";  ///< name of the DDS topic of the wiring; empty: none
  /// name of the DDS topic of the cycle statistics; empty: none
  std::string statistics_topic = "driveline/v1/cycle_statistics";
  /// name of the DDS topic of the state and the owner of axes; empty: none
  std::string axis_state_topic = "driveline/v1/axis_state";
  /// Shortest time between two axis states that differ only in digital inputs.
  std::chrono::nanoseconds input_period = std::chrono::milliseconds{10};
  std::size_t slaves = 0;  ///< maximum number of slaves of the line
  /// Time after which a slave is published even if it has not changed.
  std::chrono::nanoseconds slave_period = std::chrono::seconds{10};
  /// Also publish the ROS 2 topics `joint_states` (sensor_msgs/msg/JointState) and `diagnostics`
  /// (diagnostic_msgs/msg/DiagnosticArray), in the default partition, which ROS 2 reads.
  bool ros2 = false;
  bool joint_states = true;            ///< with `ros2`: publish joint_states
  bool diagnostics = true;             ///< with `ros2`: publish diagnostics
  std::uint32_t joint_decimation = 0;  ///< joint states of every n-th cycle; 0: a hundred times per second
  std::chrono::nanoseconds diagnostics_period = std::chrono::seconds{1};  ///< as ROS 2 tools expect; above 0
  /// Cycle period of the line. A batch holds as many cycles as fit into batch_period, up to 64, and up to 512 samples.
  /// 0: unknown, a batch holds one cycle.
  std::chrono::nanoseconds cycle_period{0};
  /// The time of the samples is not the time of this machine; their wall time is then the time of publication.
  bool virtual_time = false;
  std::chrono::nanoseconds batch_period = std::chrono::milliseconds{1};  ///< time span of a batch
  /// Axis samples are published in the cycles whose number is a multiple of this; 8 gives 1 kHz for a cycle of 125 µs.
  /// At least 1.
  std::uint32_t decimation = 8;
  bool axis_on_change = false;  ///< publish only samples that have changed, and at least one per second
  SampleRate batch_rate;        ///< selection of the samples in batches
  /// Time between two line statuses while state and faults are unchanged.
  std::chrono::nanoseconds status_period = std::chrono::milliseconds{100};
  /// IPv4 addresses of the interfaces that DDS may use; empty: all interfaces. By default telemetry stays on this
  /// machine: a servo line must not multicast into a plant network, or out of its own EtherCAT port, without being
  /// configured to.
  std::vector<std::string> interfaces = {"127.0.0.1"};
  /// IPv4 addresses of machines to which the participant is announced individually, for networks without multicast.
  /// This machine is always included if `interfaces` allows it.
  std::vector<std::string> peers;
  std::optional<DdsDiscoveryServer> discovery_server;  ///< replaces multicast and `peers`; nullopt: no server
  std::string partition;                               ///< DDS partition; empty: the default partition
  DdsProfiles profiles;                                ///< profiles of writers
  /// nullopt: every participant of the domain can read, and can claim any identity
  std::optional<DdsSecurity> security;
  /// Also use Fast DDS's shared memory for Fast DDS subscribers on this machine that run as the same user as this
  /// process; all others are sent to by UDP. Not together with `security`.
  bool shared_memory = false;
};

}  // namespace driveline::bridge
