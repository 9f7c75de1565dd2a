#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/device_signals.hpp"

namespace driveline::cli {

/// An input and its new value.
struct SignalSetting {
  std::size_t input = 0;
  double value = 0.0;
};

/// Parses "ENPO=0 ISD02=1" for a device; names may contain spaces. Error: one sentence.
[[nodiscard]] tl::expected<std::vector<SignalSetting>, std::string> parse_signal_settings(
    std::string_view text, const slaves::DeviceSignals& signals);

}  // namespace driveline::cli
