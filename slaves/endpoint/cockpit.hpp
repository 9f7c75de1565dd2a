#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "driveline/slaves/endpoint/endpoint_protocol.hpp"

namespace driveline::endpoint {

/// State of the end point.
struct CockpitState {
  slaves::DeviceStatus device;
  slaves::EndpointAddress address;
  bool link = false;                ///< the link is up: frames pass
  std::uint64_t frames_in = 0;      ///< frames from the master
  std::uint64_t frames_out = 0;     ///< frames to the master
  std::chrono::seconds running{0};  ///< time since the end point was started
};

/// Formats the state as a JSON document. The keys are the same for all devices; `values` and `parameters` contain only
/// what the device has.
[[nodiscard]] std::string state_json(const CockpitState& state);
/// Returns the self-contained page that displays the state: it reads /state.json periodically.
[[nodiscard]] std::string_view cockpit_page() noexcept;

}  // namespace driveline::endpoint
