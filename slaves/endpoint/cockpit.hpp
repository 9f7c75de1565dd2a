#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "driveline/slaves/endpoint/endpoint_protocol.hpp"

namespace driveline::endpoint {

/// What the end point knows.
struct CockpitState {
  slaves::DeviceStatus device;
  slaves::EndpointAddress address;
  bool link = false;                ///< frames pass
  std::uint64_t frames_in = 0;      ///< from the master
  std::uint64_t frames_out = 0;     ///< to the master
  std::chrono::seconds running{0};  ///< since the end point was started
};

/// The state as one JSON document. Keys stay the same, whatever the device; values it has not are left out of `values`
/// and `parameters`.
[[nodiscard]] std::string state_json(const CockpitState& state);
/// The page that shows it, complete in itself: it reads /state.json again and again.
[[nodiscard]] std::string_view cockpit_page() noexcept;

}  // namespace driveline::endpoint
