#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "driveline/runtime/axes/axis_requests.hpp"

namespace driveline::runtime {

inline ecat_master::AxisRequest ask(ecat_master::AxisCommand command, double target = 0.0) {
  ecat_master::AxisRequest request;
  request.command = command;
  request.target_si = target;
  return request;
}

inline AxisCaller caller(std::string name, std::optional<std::chrono::nanoseconds> keep_alive = std::nullopt) {
  AxisCaller caller;
  caller.name = std::move(name);
  caller.keep_alive = keep_alive;
  return caller;
}

}  // namespace driveline::runtime
