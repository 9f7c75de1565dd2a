#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/device_signals.hpp"

namespace driveline::cli {

/// An input and the value to set it to.
struct SignalSetting {
  std::size_t input = 0;
  double value = 0.0;
};

/// Reads "ENPO=0 ISD02=1" for a device; names may have spaces in them. Error: one sentence.
[[nodiscard]] tl::expected<std::vector<SignalSetting>, std::string> parse_signal_settings(
    std::string_view text, const slaves::DeviceSignals& signals);

}  // namespace driveline::cli
