#pragma once

#include <chrono>
#include <span>
#include <string>
#include <string_view>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/can/bus_fault.hpp"

namespace driveline::runtime {

/// A fault of a CAN line, and its time.
struct CanFaultPlan {
  std::chrono::nanoseconds at{0};  ///< after the line was switched on
  slaves::can::BusFault fault;     ///< the fault
};

/// Reads "power-off slave=y for_ms=500". Error: one sentence.
/// @param complete false: kind and place are enough, as for healing
[[nodiscard]] Result<slaves::can::BusFault> parse_can_fault(std::string_view text, std::span<const std::string> names,
                                                            bool complete = true);
/// Returns the text of a fault, which parse_can_fault() reads back as the same fault.
[[nodiscard]] std::string can_fault_text(const slaves::can::BusFault& fault, std::span<const std::string> names);
/// Returns all kinds and parameters, one line each.
[[nodiscard]] std::string can_fault_help();
/// Reads a [[fault]] of a CAN line. Throws a ConfigError.
[[nodiscard]] CanFaultPlan read_can_fault(TomlReader reader, std::span<const std::string> names);

}  // namespace driveline::runtime
