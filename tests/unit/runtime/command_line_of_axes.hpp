// Two axes whose cycles a test runs by hand, and commands to them as a bridge would write them.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

namespace driveline::runtime {

class AxesForCommands {
 protected:
  AxesForCommands() {
    std::vector<motion::Axis> made;
    for (const auto& config : configs) {
      made.emplace_back(config, motion::ImagePlace{}, motion::axis_pdo_configuration());
    }
    single.emplace(std::move(made), motion::SingleAxes::Settings{});
  }
  static motion::AxisConfig config(const std::string& name, std::size_t slave) {
    motion::AxisConfig axis;
    axis.name = name;
    axis.slave = slave;
    axis.limits = {10.0, 100.0};
    axis.unit = trajectory::find_position_unit("deg");
    axis.software_limits = trajectory::PositionRange{-3.0, 3.0};
    return axis;
  }
  /// Runs a cycle of the axes, without a line.
  void cycle() {
    std::vector<std::byte> image(256);
    single->update(++cycles, image);
  }
  /// The next command of a client.
  snapshot::CommandRecord command(const char* client, const char* axis, snapshot::CommandKind kind,
                                  std::uint64_t lease = 0, std::uint8_t participant = 1) {
    snapshot::CommandRecord record;
    record.participant[0] = participant;
    record.client.set(client);
    record.axis.set(axis);
    record.number = ++number;
    record.lease = lease;
    record.kind = static_cast<std::uint32_t>(kind);
    return record;
  }

  std::vector<motion::AxisConfig> configs{config("x", 0), config("y", 1)};
  std::optional<motion::SingleAxes> single;
  std::int64_t cycles = 0;
  std::uint64_t number = 0;
};

}  // namespace driveline::runtime
