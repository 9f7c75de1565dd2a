#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace driveline::rt {

/// How much a shortcoming costs at worst, in the order of importance.
enum class Cost : std::uint8_t {
  kUnknown,       ///< nothing, or not known
  kMicroseconds,  ///< delays of some microseconds, or seldom ones
  kPeriods,       ///< delays of a period of 125 us and more
  kPrevents,      ///< no real-time operation at all
};

/// One fact about the real-time set-up: what was asked for and what the kernel says is in effect.
struct RealtimeItem {
  std::string name;              ///< e.g. "scheduler"
  std::string requested;         ///< e.g. "SCHED_FIFO 80"; "not requested" if it was left alone
  std::string effective;         ///< read back after setting, e.g. "SCHED_OTHER"
  bool ok = true;                ///< what was requested is in effect
  int error_number = 0;          ///< errno of the call that was refused; 0 if it succeeded or there was none
  std::string remedy;            ///< what to do about it, as a command where there is one; empty if ok
  Cost cost = Cost::kUnknown;    ///< how much the shortcoming costs; kUnknown if ok
  std::string consequence = {};  ///< what it costs in words; empty if ok
};

/// The real-time set-up of one thread as it is in effect.
struct RealtimeReport {
  std::vector<RealtimeItem> settings;  ///< what driveline sets and reads back; `enforce` insists on all of them
  RealtimeItem cpu_latency;            ///< what the kernel was asked for idle CPUs; never a reason to refuse
  std::vector<RealtimeItem> platform;  ///< properties of kernel and machine; advice, never a reason to refuse

  /// Whether every requested setting is in effect.
  [[nodiscard]] bool complete() const noexcept;
};

/// Why a thread was not started under RealtimePolicy::kEnforce.
struct RealtimeError {
  RealtimeReport report;  ///< what was asked for and what is in effect

  /// One sentence for each setting that is not in effect: what was requested and found, the error text and the remedy.
  [[nodiscard]] std::string message() const;
};

/// The item that costs most among those that are not ok, the first of them if several do; null if all are ok.
[[nodiscard]] const RealtimeItem* most_important(const std::vector<RealtimeItem>& items) noexcept;

/// What was found instead of what was asked for, with the error text and the remedy.
[[nodiscard]] std::string shortcoming(const RealtimeItem& item);

/// The report as lines of text without line ends: one per setting, then the most important finding about kernel and
/// machine. All of those are what `driveline doctor` shows.
[[nodiscard]] std::vector<std::string> to_lines(const RealtimeReport& report);

}  // namespace driveline::rt
