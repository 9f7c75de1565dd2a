#pragma once

#include <string>
#include <vector>

namespace driveline::rt {

/// One fact about the real-time set-up: what was asked for and what the kernel says is in effect.
struct RealtimeItem {
  std::string name;       ///< e.g. "scheduler"
  std::string requested;  ///< e.g. "SCHED_FIFO 80"; "not requested" if it was left alone
  std::string effective;  ///< read back after setting, e.g. "SCHED_OTHER"
  bool ok = true;         ///< what was requested is in effect
  int error_number = 0;   ///< errno of the call that was refused; 0 if it succeeded or there was none
  std::string remedy;     ///< what to do about it; empty if ok
};

/// The real-time set-up of one thread as it is in effect.
struct RealtimeReport {
  std::vector<RealtimeItem> settings;  ///< what driveline sets and reads back; `enforce` insists on all of them
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

/// The report as lines of text without line ends, one per item.
[[nodiscard]] std::vector<std::string> to_lines(const RealtimeReport& report);

}  // namespace driveline::rt
