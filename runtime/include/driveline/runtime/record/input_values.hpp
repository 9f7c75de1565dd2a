#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"

namespace driveline::runtime {

/// An input of the process image and its value when it was read.
struct InputValue {
  std::string name;  ///< "slave2.Status word", from ProcessVariables::full_name()
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  unsigned bits = 0;
  std::optional<std::uint64_t> value;  ///< none: more than 64 bits
};

/// Reads all inputs of `variables` from the input bytes of the process image, which must not change meanwhile.
[[nodiscard]] std::vector<InputValue> read_inputs(const ecat_master::ProcessVariables& variables,
                                                  std::span<const std::byte> inputs);

}  // namespace driveline::runtime
