#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::ecat_master {

/// One port of a slave: its link and its error counters. The counters stop at 255.
struct PortDiagnosis {
  wire::DlStatus::Port status;      ///< DL status 0110h
  std::uint8_t invalid_frames = 0;  ///< came in damaged here, for the first time on their way (0300h)
  std::uint8_t receive_errors = 0;  ///< symbols the physical layer could not read, in and between frames (0301h)
  std::uint8_t forwarded = 0;       ///< damaged and marked as such by a slave before (0308h)
  std::uint8_t lost_links = 0;      ///< 0310h
};

/// One slave at the time of the diagnosis.
struct SlaveDiagnosis {
  std::string name;       ///< as planned; empty without a plan
  SlaveRef ref;           ///< position and station address
  bool optional = false;  ///< hot-connected: it may be missing
  bool answers = false;   ///< false: everything below is empty
  AlReport al;            ///< AL state, error indication, AL status code
  std::array<PortDiagnosis, kSlavePorts> ports{};
  std::uint8_t processing_unit_errors = 0;  ///< frames that are no proper EtherCAT frames (030Ch)
  std::uint8_t pdi_errors = 0;              ///< accesses of the slave's own processor (030Dh)
};

/// A fault and its place, computed from the counters of all slaves.
struct FaultPlace {
  /// Kind of fault.
  enum class Kind : std::uint8_t {
    kDamagedFrames,  ///< frames come in damaged at `port`
    kLostLink,       ///< the link at `port` has been lost `count` times
    kNoLink,         ///< there was a cable at `port` when the line was scanned; now there is no link
    kNoAnswer,       ///< the link is there, but the slave behind it does not answer to its address
    kBadFrames,      ///< the slave's processing unit got frames that are no valid EtherCAT frames
    kPdi,            ///< the slave's own processor fails to access its controller
  };
  Kind kind = Kind::kDamagedFrames;      ///< decides which of the members below count
  std::uint16_t slave = 0;               ///< position of the slave that noticed it
  std::uint8_t port = 0;                 ///< of that slave, 0 to 3
  std::optional<std::uint16_t> other{};  ///< the slave at the other end of the cable; none: the master
  std::uint32_t count = 0;               ///< as the counters have it; they stop at 255
};

/// One group of the cyclic exchange since it began.
struct GroupDiagnosis {
  std::uint64_t exchanges = 0;        ///< cycles in which the group was due
  std::uint64_t lost_frames = 0;      ///< not back within their cycle
  std::uint64_t wkc_errors = 0;       ///< frames back with another working counter than that of a complete line
  std::uint32_t bad_cycles = 0;       ///< in a row, now
  std::uint32_t longest_bad = 0;      ///< in a row, at worst
  std::uint32_t working_counter = 0;  ///< sum over its frames in the last exchange
  std::uint32_t expected_working_counter = 0;  ///< the same of a complete line
  bool outputs_zeroed = false;                 ///< GroupSettings::bad_cycle_limit was reached
};

/// Diagnosis of a line.
struct LineDiagnosis {
  std::chrono::nanoseconds time{0};    ///< when it was made, on the master's clock
  std::vector<SlaveDiagnosis> slaves;  ///< by position
  std::vector<FaultPlace> places;      ///< see locate_faults()
  /// Further problems of the line, one sentence each: unusable EEPROMs, duplicate aliases; a caller that knows the
  /// plans adds the differences.
  std::vector<std::string> problems;
  std::vector<GroupDiagnosis> groups;  ///< empty while no cycle runs
  std::uint64_t cycles = 0;            ///< so far; 0 while no cycle runs
  std::uint64_t stale_frames = 0;      ///< came back after their cycle
  std::uint64_t foreign_frames = 0;    ///< frames of other senders
  /// Of a cycle that has ended; while it runs only the cycle may read them, but a consumer of its samples may fill this
  /// in.
  std::optional<CycleStatistics> statistics;
  /// The round trip in `statistics` is that of a simulated line; set by the caller that fills `statistics` in.
  bool round_trip_modelled = false;
  std::optional<port::RingStatus> ring;                  ///< nothing without a ring
  std::optional<LineSupervisor::GuardStatistics> guard;  ///< of the registers; none: they are not read back
  std::vector<LineEvent> events;                         ///< LineSupervisor::history()
  std::vector<CyclicEvent> exchange_history;             ///< LineSupervisor::exchange_history()
  std::vector<CyclicEvent> state_history;                ///< of slaves, from the status bytes in their process data
  std::vector<EmergencyRecord> emergencies;              ///< of all slaves, in order of time
};

/// Reads states, links and error counters of all slaves in parallel; slaves that do not answer are marked. Errors:
/// those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveDiagnosis>> read_slave_diagnosis(Bus& bus,
                                                                       std::span<const ConfiguredSlave> slaves);

/// Sets the error counters of all slaves to zero. Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<void> clear_error_counters(Bus& bus);

/// Locates the faults. A damaged frame is counted at the port it comes in at (invalid frames) and marked, so that all
/// slaves behind count it as forwarded: the cable, or the sender at its other end, is at the port that counts invalid
/// frames (ESC data sheet I, "Error counters"). `topology` tells which slave is at the other end.
[[nodiscard]] std::vector<FaultPlace> locate_faults(std::span<const SlaveDiagnosis> slaves, const Topology& topology);

/// The whole diagnosis of a line that has been scanned. `supervisor` and `ring` may be null. Errors: those of the bus.
/// Not real-time safe.
[[nodiscard]] Result<LineDiagnosis> diagnose(Master& master, const LineSupervisor* supervisor,
                                             const port::RedundantPort* ring);

/// "slave 3: ..." as one sentence. Allocates.
[[nodiscard]] std::string describe(const FaultPlace& place);
/// "0.125000 s group 0: working counter 21 of 24".
[[nodiscard]] std::string describe(const CyclicEvent& event);
/// The diagnosis as one page of text.
[[nodiscard]] std::string to_text(const LineDiagnosis& diagnosis);

}  // namespace driveline::ecat_master
