#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::ecat_master {

/// A port of a slave: its link and its error counters. The counters stop at 255.
struct PortDiagnosis {
  wire::DlStatus::Port status;      ///< DL status 0110h
  std::uint8_t invalid_frames = 0;  ///< invalid frames first detected at this port (0300h)
  std::uint8_t receive_errors = 0;  ///< symbols that the physical layer could not decode, in and between frames (0301h)
  std::uint8_t forwarded = 0;       ///< invalid frames already marked by a previous slave (0308h)
  std::uint8_t lost_links = 0;      ///< lost links (0310h)
};

/// A slave at the time of the diagnosis.
struct SlaveDiagnosis {
  std::string name;       ///< planned name; empty without a plan
  SlaveRef ref;           ///< position and station address
  bool optional = false;  ///< hot-connect slave: it may be missing
  bool answers = false;   ///< false: all members below are empty
  AlReport al;            ///< AL state, error indication, AL status code
  std::array<PortDiagnosis, kSlavePorts> ports{};
  std::uint8_t processing_unit_errors = 0;  ///< invalid EtherCAT frames (030Ch)
  std::uint8_t pdi_errors = 0;              ///< failed accesses by the slave's processor (030Dh)
};

/// A fault and its location, computed from the counters of all slaves.
struct FaultPlace {
  /// Kind of fault.
  enum class Kind : std::uint8_t {
    kDamagedFrames,  ///< frames arrive damaged at `port`
    kLostLink,       ///< the link at `port` was lost `count` times
    kNoLink,         ///< `port` had a cable when the line was scanned; now it has no link
    kNoAnswer,       ///< the link is up, but the slave behind it does not answer at its address
    kBadFrames,      ///< the slave's processing unit received invalid EtherCAT frames
    kPdi,            ///< the slave's processor fails to access its controller
  };
  Kind kind = Kind::kDamagedFrames;      ///< determines which of the following members are used
  std::uint16_t slave = 0;               ///< position of the slave that detected it
  std::uint8_t port = 0;                 ///< port of that slave, 0 to 3
  std::optional<std::uint16_t> other{};  ///< the slave at the other end of the cable; empty: the master
  std::uint32_t count = 0;               ///< value of the counter; stops at 255
};

/// One group of the cyclic exchange since its start.
struct ExchangeGroupDiagnosis {
  std::uint64_t exchanges = 0;        ///< cycles in which the group was due
  std::uint64_t lost_frames = 0;      ///< frames not returned within their cycle
  std::uint64_t wkc_errors = 0;       ///< frames returned with another working counter than that of a complete line
  std::uint32_t bad_cycles = 0;       ///< current number of consecutive bad cycles
  std::uint32_t longest_bad = 0;      ///< largest number of consecutive bad cycles
  std::uint32_t working_counter = 0;  ///< sum over the group's frames in the last exchange
  std::uint32_t expected_working_counter = 0;  ///< expected sum for a complete line
  bool outputs_zeroed = false;                 ///< ExchangeGroupSettings::bad_cycle_limit was reached
};

/// Diagnosis of a line.
struct LineDiagnosis {
  std::chrono::nanoseconds time{0};    ///< time of the diagnosis on the master's clock
  std::vector<SlaveDiagnosis> slaves;  ///< by position
  std::vector<FaultPlace> places;      ///< see locate_faults()
  /// Further problems of the line, one sentence each: unusable EEPROMs, duplicate aliases, repeated mailbox requests
  /// and mailbox counters; a caller that knows the plans adds the differences.
  std::vector<std::string> problems;
  std::vector<ExchangeGroupDiagnosis> groups;  ///< empty while no cycle runs
  std::uint64_t cycles = 0;                    ///< cycles so far; 0 while no cycle runs
  std::uint64_t stale_frames = 0;              ///< frames returned after their cycle
  std::uint64_t foreign_frames = 0;            ///< frames of other senders
  /// Statistics of a cycle that has ended; while it runs only the cycle may read them, but a consumer of its samples
  /// may fill them in.
  std::optional<motion::CycleStatistics> statistics;
  /// Whether the round trip in `statistics` is that of a simulated line; set by the caller that fills in `statistics`.
  bool round_trip_modelled = false;
  std::optional<port::RingStatus> ring;  ///< empty without a ring
  std::optional<LineSupervisor::GuardStatistics>
      guard;                                  ///< statistics of the register guard; empty: registers are not read back
  std::vector<LineEvent> events;              ///< LineSupervisor::history()
  std::vector<CyclicEvent> exchange_history;  ///< LineSupervisor::exchange_history()
  std::vector<CyclicEvent> state_history;     ///< states of slaves, from the status bytes in their process data
  std::vector<EmergencyRecord> emergencies;   ///< emergencies of all slaves, in order of time
};

/// Reads states, links and error counters of all slaves in parallel; marks slaves that do not answer. Errors: those of
/// the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveDiagnosis>> read_slave_diagnosis(Bus& bus,
                                                                       std::span<const ConfiguredSlave> slaves);

/// Sets the error counters of all slaves to zero. Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<void> clear_error_counters(Bus& bus);

/// Locates the faults. A damaged frame is counted at the port where it arrives (invalid frames) and marked, so that all
/// following slaves count it as forwarded: the faulty cable, or the sender at its other end, is at the port that counts
/// invalid frames (ESC data sheet I, "Error counters"). `topology` gives the slave at the other end.
[[nodiscard]] std::vector<FaultPlace> locate_faults(std::span<const SlaveDiagnosis> slaves, const Topology& topology);

/// The complete diagnosis of a scanned line. `supervisor` and `ring` may be null. Errors: those of the bus. Not
/// real-time safe.
[[nodiscard]] Result<LineDiagnosis> diagnose(Master& master, const LineSupervisor* supervisor,
                                             const port::RedundantPort* ring);

/// The fault in one sentence: "slave 3: ...". Allocates.
[[nodiscard]] std::string describe(const FaultPlace& place);
/// The event in one sentence: "0.125000 s group 0: working counter 21 of 24".
[[nodiscard]] std::string describe(const CyclicEvent& event);
/// The diagnosis as one page of text.
[[nodiscard]] std::string to_text(const LineDiagnosis& diagnosis);

}  // namespace driveline::ecat_master
