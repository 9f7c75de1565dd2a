#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace driveline::rt {

/// How much a shortcoming costs at worst, in ascending order.
enum class Cost : std::uint8_t {
  kUnknown,       ///< no cost, or an unknown one
  kMicroseconds,  ///< delays of some microseconds, or rare ones
  kPeriods,       ///< delays of a period of 125 us or more
  kPrevents,      ///< no real-time operation at all
};

/// One fact about the real-time set-up: the requested value and the value that the kernel reports.
struct RealtimeItem {
  std::string name;              ///< e.g. "scheduler"
  std::string requested;         ///< e.g. "SCHED_FIFO 80"; "not requested" if the setting was not changed
  std::string effective;         ///< read back after setting, e.g. "SCHED_OTHER"
  bool ok = true;                ///< the requested value is in effect
  int error_number = 0;          ///< errno of the call that failed; 0 if it succeeded or there was none
  std::string remedy;            ///< remedy, as a command where there is one; empty if ok
  Cost cost = Cost::kUnknown;    ///< cost of the shortcoming; kUnknown if ok
  std::string consequence = {};  ///< the cost in words; empty if ok
};

/// The real-time set-up of a thread as currently in effect.
struct RealtimeReport {
  std::vector<RealtimeItem> settings;  ///< settings that driveline makes and reads back; kEnforce requires all of them
  RealtimeItem cpu_latency;            ///< requested wake-up time of idle CPUs; never a reason to refuse
  std::vector<RealtimeItem> platform;  ///< properties of kernel and machine; advice, never a reason to refuse

  /// Whether every requested setting is in effect.
  [[nodiscard]] bool complete() const noexcept;
};

/// Why a thread was not started under RealtimePolicy::kEnforce.
struct RealtimeError {
  RealtimeReport report;  ///< requested settings and settings in effect

  /// One sentence for each setting that is not in effect: what was requested and found, the error text and the remedy.
  [[nodiscard]] std::string message() const;
};

/// The error as sentences.
[[nodiscard]] inline std::string describe(const RealtimeError& error) {
  return error.message();
}

/// The most costly of the items that are not ok, the first of them in a tie; null if all are ok.
[[nodiscard]] const RealtimeItem* most_important(const std::vector<RealtimeItem>& items) noexcept;

/// States what is in effect instead of the requested value, with the error text and the remedy.
[[nodiscard]] std::string shortcoming(const RealtimeItem& item);

/// The report as lines of text without line ends: one per setting, then the most important finding about kernel and
/// machine. `driveline doctor` shows all of these findings.
[[nodiscard]] std::vector<std::string> to_lines(const RealtimeReport& report);

}  // namespace driveline::rt
