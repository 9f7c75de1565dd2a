#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace driveline::bridge {

/// What an axis moves along, and with it the unit of its telemetry.
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

/// Files of DDS Security (OMG DDS Security 1.1, 8.3 and 8.4) that say who this participant is, whom it believes, and
/// what who may do. Others in the domain who have none, or whom the permissions do not name, see nothing.
struct DdsSecurity {
  std::string identity_ca;     ///< certificate of the authority that signs identities, PEM
  std::string certificate;     ///< own identity, PEM
  std::string private_key;     ///< of the identity, PEM
  std::string permissions_ca;  ///< certificate of the authority that signs the next two, PEM
  std::string governance;      ///< rules of the domain, signed
  std::string permissions;     ///< what this participant may do, signed
};

/// Which samples of the axes a topic has.
struct SampleRate {
  std::uint32_t cycles = 1;  ///< those of every cycle whose number it divides; at least 1
  /// Of these only the ones in which something but cycle and time has changed, and one in a second.
  bool on_change = false;
};

/// Where a discovery server of Fast DDS listens: whoever asks it is told of all others who do.
struct DdsDiscoveryServer {
  std::string address;     ///< IPv4
  std::uint16_t port = 0;  ///< of UDP; its GUID prefix is that of server 0, 44.53.00.5f.45.50.52.4f.53.49.4d.41
};

/// Profiles of Fast DDS for writers; the name of a profile is that of its topic.
struct DdsProfiles {
  std::string xml;   ///< content of the file; empty: none
  std::string file;  ///< what it is called in messages
};

/// Where and how often a DdsPublisher publishes.
struct DdsConfig {
  std::uint32_t domain_id = 0;                 ///< 0 to 232; above 100 its ports meet Linux's ephemeral ports
  std::string participant_name = "driveline";  ///< shown by DDS tools
  std::string line_name = "line";              ///< 1 to 31 bytes
  std::vector<AxisInfo> axes;                  ///< by axis index; samples of other axes are refused and counted
  std::string axis_topic = "driveline/axis_telemetry";  ///< name of the DDS topic of the axis samples; empty: none
  std::string status_topic = "driveline/line_status";   ///< name of the DDS topic of the line's status
  /// Name of the DDS topic of batches: all axes in every cycle. Empty: none.
  std::string batch_topic = "driveline/v1/axis_batch";
  std::string event_topic = "driveline/v1/event";                  ///< name of the DDS topic of events; empty: none
  std::string slave_topic = "driveline/v1/slave";                  ///< name of the DDS topic of the slaves; empty: none
  std::string topology_topic = "driveline/v1/topology";            ///< name of the DDS topic of the wiring; empty: none
  std::string statistics_topic = "driveline/v1/cycle_statistics";  ///< of the cycle's statistics; empty: none
  std::string axis_state_topic = "driveline/v1/axis_state";  ///< of what axes do, and who commands them; empty: none
  /// Shortest time between two samples of an axis of which only digital inputs have changed.
  std::chrono::nanoseconds input_period = std::chrono::milliseconds{10};
  std::size_t slaves = 0;  ///< most slaves of the line
  /// Time after which a slave is published although nothing of it has changed.
  std::chrono::nanoseconds slave_period = std::chrono::seconds{10};
  /// Also publishes the ROS 2 topics `joint_states` (sensor_msgs/msg/JointState) and `diagnostics`
  /// (diagnostic_msgs/msg/DiagnosticArray), in the default partition, in which ROS 2 reads.
  bool ros2 = false;
  bool joint_states = true;            ///< with `ros2`: that topic
  bool diagnostics = true;             ///< with `ros2`: that topic
  std::uint32_t joint_decimation = 0;  ///< joint states of every n-th cycle; 0: a hundred times in a second
  std::chrono::nanoseconds diagnostics_period = std::chrono::seconds{1};  ///< what ROS 2 tools expect; above 0
  /// Of the line; a batch has as many cycles as batch_period holds, up to 64, and up to 512 samples. 0: not known, a
  /// batch has one cycle.
  std::chrono::nanoseconds cycle_period{0};
  /// The time of the samples is not that of this machine: their wall time is that of their publication.
  bool virtual_time = false;
  std::chrono::nanoseconds batch_period = std::chrono::milliseconds{1};  ///< of the cycles in one batch
  /// Axis samples are published in every cycle whose number it divides; 8 makes 1 kHz of a 125 µs cycle. At least 1.
  std::uint32_t decimation = 8;
  bool axis_on_change = false;  ///< of these only the ones in which something has changed, and one in a second
  SampleRate batch_rate;        ///< of the samples in batches
  /// Time between two line statuses while the state and the faults stay as they are.
  std::chrono::nanoseconds status_period = std::chrono::milliseconds{100};
  /// IPv4 addresses of the interfaces DDS may use; empty: every interface. By default telemetry stays on this machine:
  /// a servo line must not start to multicast into a plant network, or out of its own EtherCAT port, unasked.
  std::vector<std::string> interfaces = {"127.0.0.1"};
  /// IPv4 addresses of machines to announce ourselves to one by one, for networks without multicast. The own machine
  /// is always among them while `interfaces` allows it.
  std::vector<std::string> peers;
  std::optional<DdsDiscoveryServer> discovery_server;  ///< in place of multicast and peers; none: without
  std::string partition;                               ///< of DDS; empty: the default one
  DdsProfiles profiles;                                ///< of writers
  std::optional<DdsSecurity> security;  ///< none: everybody in the domain reads, and may say that he is somebody else
  /// To subscribers of Fast DDS on this machine that belong to the same user as this process, also by Fast DDS's shared
  /// memory; to all others by UDP. Not with `security`.
  bool shared_memory = false;
};

}  // namespace driveline::bridge
