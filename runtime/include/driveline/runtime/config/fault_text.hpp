#pragma once

#include <span>
#include <string>
#include <string_view>
#include "driveline/runtime/error.hpp"

#include "driveline/slaves/line/fault.hpp"
#include "driveline/slaves/line/wiring.hpp"

namespace driveline::runtime {

/// Names that fault texts may refer to.
struct FaultPlaces {
  std::span<const std::string> slaves;  ///< names by position
  const slaves::Wiring& wiring;
};

/// A fault under construction, parameter by parameter; used for the line description and the command line.
class FaultDraft {
 public:
  /// A fault of the kind `row` without parameters.
  explicit FaultDraft(const slaves::FaultKindRow& row) : row_(row) { fault_.kind = row.kind; }

  /// Sets a parameter from its text. Error: the reason, without the name of the parameter.
  [[nodiscard]] Result<void> set(const slaves::FaultParameterRow& parameter, std::string_view value,
                                 const FaultPlaces& places);
  /// Duration of the fault; zero: until it is healed.
  void set_duration(std::chrono::nanoseconds duration) noexcept { fault_.duration = duration; }
  /// Returns the complete fault. Error: a parameter is missing or contradicts another.
  /// @param complete false: kind and place are enough, as for healing
  [[nodiscard]] Result<slaves::Fault> finish(const FaultPlaces& places, bool complete = true) const;

 private:
  [[nodiscard]] Result<slaves::Fault> with_cable(slaves::Fault fault, const FaultPlaces& places) const;
  const slaves::FaultKindRow& row_;
  slaves::Fault fault_;
  std::uint16_t to_ = 0;
  slaves::FaultParameters given_ = 0;
};

/// Returns the slave with this name or position. Error: a sentence.
[[nodiscard]] Result<std::uint16_t> parse_slave(std::string_view text, std::span<const std::string> names);
/// Returns the fault kind with this name. Error: a sentence that lists the names.
[[nodiscard]] Result<const slaves::FaultKindRow*> find_fault_kind(std::string_view name);
/// Returns the parameters of the kind, "slave, time_us"; "nothing" if it has none.
[[nodiscard]] std::string parameters_of(const slaves::FaultKindRow& row);

/// Reads "power-off slave=y for_ms=500". Error: one sentence.
/// @param complete false: kind and place are enough, as for healing
[[nodiscard]] Result<slaves::Fault> parse_fault(std::string_view text, const FaultPlaces& places, bool complete = true);
/// Returns the text of a fault, which parse_fault() reads back as the same fault.
[[nodiscard]] std::string fault_text(const slaves::Fault& fault, const FaultPlaces& places);
/// Returns all kinds and parameters, one line each.
[[nodiscard]] std::string fault_help();

}  // namespace driveline::runtime
