#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include "driveline/runtime/error.hpp"

#include "driveline/ecat_master/cyclic/receive_wait.hpp"
#include "driveline/ecat_master/dc/line_clocks.hpp"
#include "driveline/esi/esi_library.hpp"
#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/control/master_absence.hpp"
#include "driveline/motion/single_axis/gantry_settings.hpp"
#include "driveline/port/interface_port.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/config/can_bus_config.hpp"
#include "driveline/runtime/config/command_config.hpp"
#include "driveline/runtime/config/coupling_config.hpp"
#include "driveline/runtime/config/eoe_config.hpp"
#include "driveline/runtime/config/process_data_config.hpp"
#include "driveline/runtime/config/recovery_config.hpp"
#include "driveline/runtime/config/slave_plan_config.hpp"
#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/config/telemetry_config.hpp"
#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "driveline/slaves/line/fault.hpp"
#include "driveline/slaves/line/frame_path.hpp"
#include "driveline/slaves/line/wiring.hpp"
#include "driveline/slaves/persona/persona.hpp"
#include "driveline/trajectory/interpolation_method.hpp"

namespace driveline::runtime {

/// Most increments per revolution of an axis: positions have 32 bits.
inline constexpr double kMaxIncrementsPerRevolution = 4294967295.0;

/// Distributed clock of a slave. Values that are left out come from its EEPROM.
struct SlaveClockConfig {
  bool synchronous = true;                              ///< false: no SYNC signals, free run
  std::optional<std::string> op_mode;                   ///< name of the operation mode
  std::optional<std::chrono::nanoseconds> sync0_cycle;  ///< `sync0_cycle_us`
  std::optional<std::chrono::nanoseconds> sync0_shift;  ///< `sync0_shift_us`
  std::optional<std::chrono::nanoseconds> sync1_cycle;  ///< `sync1_cycle_us`
  std::optional<std::chrono::nanoseconds> sync1_shift;  ///< `sync1_shift_us`
  double processing_extra_ns = 0.0;                     ///< tDiff of its controller, for the propagation delays
  double drift_ppm = 0.0;                               ///< drift of the simulated oscillator
};

/// [dc] of a line description.
struct ClockConfig {
  ecat_master::dc::FollowMode mode = ecat_master::dc::FollowMode::kMasterFollows;  ///< which clock leads
  /// Time source of the clocks: the master's monotonic clock, CLOCK_REALTIME, or CLOCK_TAI.
  enum class Time : std::uint8_t { kMonotonic, kSystem, kTai };
  Time time = Time::kMonotonic;
  std::optional<std::uint16_t> reference;  ///< position of the reference slave; none: the first one with a clock
  std::chrono::nanoseconds frame_lead{};   ///< time by which the frames pass the reference clock before SYNC0
};

/// A [[slave]]: identity and configuration for the master, and the device for the simulation.
struct SlaveConfig {
  std::string name;  ///< unique on the line
  /// The simulated device. It also determines the expected identity where the members below are left out. Never null.
  std::shared_ptr<const SlaveDevice> device = standard_device();
  /// Device description for the configuration by the master; none: the one in [bus] esi, else the EEPROM.
  std::shared_ptr<const esi::DeviceDescription> esi;
  std::optional<std::uint32_t> vendor_id;     ///< expected vendor; default: that of `esi` or `device`
  std::optional<std::uint32_t> product_code;  ///< expected product code; default: that of `esi` or `device`
  SlavePlanConfig plan;                       ///< further identity, start-up SDOs, PDOs, watchdogs, time limits
  std::size_t group = 0;                      ///< number in ProcessDataConfig::groups
  std::vector<EntryName> names;               ///< names of entries in its process data
  slaves::SlaveDelays delays{};               ///< delays of the simulated controller
  SlaveClockConfig dc;                        ///< its clock and SYNC signals
  std::optional<wire::IpV4Address> ip;        ///< address of its EoE port; none: it does not use EoE
  std::vector<slaves::Persona> personas;      ///< quirks of the simulated device
  std::filesystem::path sii_file;             ///< file in which `simulate` stores the EEPROM content; empty: none
  std::vector<std::byte> sii_content;         ///< content of sii_file; empty: the file does not exist yet
  CanSlaveConfig can{};                       ///< its node, on a CAN line
};

/// [path] of a line description: source of the setpoints.
struct PathConfig {
  std::filesystem::path file;  ///< CSV with a time column and one column per axis
  /// Interpolation between the points.
  trajectory::InterpolationMethod interpolation = trajectory::InterpolationMethod::kClampedSpline;
  bool repeat = false;                                  ///< start again at the end
  motion::LatePolicy late = motion::LatePolicy::kStay;  ///< whether a late path catches up
  bool relative = false;              ///< positions are relative to those at which the axes are enabled
  bool compensate_dead_time = false;  ///< setpoints lead the path by the dead times of bus and drives
};

/// [output] of a line description.
struct OutputConfig {
  std::filesystem::path directory = "out";       ///< relative to the working directory
  bool plots = true;                             ///< plots in addition to the CSV files
  bool increments = false;                       ///< drive increments in addition to positions in the unit of the axis
  std::optional<std::filesystem::path> capture;  ///< pcapng of all frames
};

/// A fault of the simulated line, and its time.
struct FaultPlan {
  std::chrono::nanoseconds at{};  ///< time since the line was switched on
  slaves::Fault fault;            ///< the fault
};

/// [gateway] of a line description: access of vendor tools to the mailboxes.
struct GatewayConfig {
  GatewaySettings settings;         ///< address and protocols of the gateway
  std::vector<std::size_t> slaves;  ///< numbers of the accessible [[slave]] tables; default: all
};

/// A line description file.
struct LineConfig {
  std::string name = "line";                                         ///< for messages and telemetry
  DeviceRegistry devices;                                            ///< families of slaves and drives
  std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< cycle time of the master
  std::optional<CanBusConfig> can;                                   ///< none: a line of EtherCAT
  /// Network interface, or on a CAN line the text of canopen::open_can_port(); none: the simulated line in this
  /// process.
  std::optional<std::string> interface;
  std::optional<std::string> interface2;            ///< interface at the far end of a ring
  port::PortChoice port = port::PortChoice::kAuto;  ///< port type that sends and receives the frames of the cycle
  std::optional<std::chrono::nanoseconds> launch_ahead{};  ///< time by which frames reach the kernel before they leave
  std::shared_ptr<const esi::EsiLibrary> esi_library;      ///< for slaves without `esi`; null: none
  /// Consecutive cycles without valid process data of an axis until all axes are stopped.
  std::uint32_t max_lost_cycles = 8;
  /// The limit as a time, if the file gives one; max_lost_cycles is the number of whole cycles in it.
  std::optional<double> max_lost_ms;
  /// Bytes per cycle for SDO and other acyclic frames on the wire; none: whatever the process data leave free.
  std::optional<std::size_t> acyclic_bytes;
  rt::RealtimeConfig realtime;                           ///< all settings but the policy
  std::optional<rt::RealtimePolicy> policy;              ///< none: enforced only on a network interface
  std::optional<std::chrono::nanoseconds> wake_ahead{};  ///< none: chosen for the machine, see rt::CycleTimer
  ecat_master::ReceiveStrategy receive{};                ///< how a cycle waits for its frames
  std::optional<int> simulation_cpu;                     ///< CPU on which `simulate` runs its slaves
  std::vector<SlaveConfig> slaves;                       ///< by position
  ProcessDataConfig process_data;                        ///< groups, copies, layout
  std::optional<slaves::Wiring> wiring;                  ///< wiring of the simulated line; none: a plain line
  std::vector<FaultPlan> faults;                         ///< in the order of the file
  std::optional<ClockConfig> clocks;                     ///< none: the drives run free
  std::vector<motion::AxisConfig> axes;                  ///< in the order of the path's columns
  std::vector<AxisGroupConfig> axis_groups;              ///< in the order of the file
  std::vector<motion::GantrySettings> gantries;          ///< pairs of axes that move as one
  std::optional<PathConfig> path;                        ///< none: the axes hold the position at which they are enabled
  TelemetryConfig telemetry;                             ///< publication over DDS
  std::optional<CommandConfig> commands;                 ///< none: no commands over DDS
  OutputConfig output;                                   ///< output files
  std::optional<EoeConfig> eoe;                          ///< none: no EoE
  std::optional<GatewayConfig> gateway;                  ///< none: no mailbox gateway
  std::optional<StreamConfig> stream;                    ///< none: no setpoints from other processes
  CouplingPlan couplings;                                ///< gears and cams
  RecoveryConfig recovery;                               ///< reaction to lost slaves
  std::vector<std::string> notes;                        ///< remarks for the author of the file, one sentence each
};

/// Longest absence of process data or of the master that axes bridge without stopping.
struct LostLimit {
  std::uint32_t cycles = 0;  ///< LineConfig::max_lost_cycles
  std::optional<double> ms;  ///< LineConfig::max_lost_ms
};
/// Returns the limit of a line.
[[nodiscard]] inline LostLimit lost_limit(const LineConfig& config) {
  return {config.max_lost_cycles, config.max_lost_ms};
}
/// Returns the limit in the terms of the file: "the 8 cycles that [bus] max_lost_cycles allows".
[[nodiscard]] std::string max_lost_text(const LostLimit& limit);

/// Whether the setpoints of the line lead its path by the dead times of bus and drives.
[[nodiscard]] inline bool compensates_dead_time(const LineConfig& config) noexcept {
  return config.path && config.path->compensate_dead_time;
}

/// Returns the number of cycles between two exchanges with a slave: the divider of its group.
[[nodiscard]] std::uint32_t exchange_divider(const LineConfig& config, const SlaveConfig& slave) noexcept;

/// Returns the identity that the master expects of a slave.
[[nodiscard]] DeviceIdentity expected_identity(const SlaveConfig& slave);

/// Returns the rules of the drive with the expected identity. Valid as long as the families of `config`.
[[nodiscard]] const DriveRules& drive_rules(const LineConfig& config, const SlaveConfig& slave);

/// Reads a line description (TOML) whose slaves are of the families in `devices`. Checks every key: unknown keys, wrong
/// types and values out of range are errors with a sentence that starts with file:line and says what was expected.
/// Paths in the file are relative to the file, except the output directory, which is relative to the working directory.
/// `mode` (CSP, CSV or CST) overrides the `mode` of every axis; the file is checked as if it contained it. Lines with
/// [bus] type = "can" have LineConfig::can; what they cannot have is an error, too.
[[nodiscard]] Result<LineConfig> load_line_config(const std::filesystem::path& file,
                                                  const DeviceRegistry& devices = DeviceRegistry{},
                                                  std::optional<motion::cia402::Mode> mode = std::nullopt);

/// Same for text in memory; `name` stands for the file in errors.
[[nodiscard]] Result<LineConfig> parse_line_config(std::string_view text, const std::filesystem::path& name,
                                                   const DeviceRegistry& devices = DeviceRegistry{},
                                                   std::optional<motion::cia402::Mode> mode = std::nullopt);

}  // namespace driveline::runtime
