#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "driveline/runtime/axes/axis_requests.hpp"

namespace driveline::runtime {

inline motion::AxisRequest ask(motion::AxisCommand command, double target = 0.0) {
  motion::AxisRequest request;
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
