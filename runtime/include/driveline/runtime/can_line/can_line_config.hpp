#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/slaves/can/wiring.hpp"

namespace driveline::runtime {

/// A [[slave]] of a CAN line.
struct CanNodeConfig {
  std::string name;                           ///< unique on the line
  std::uint8_t node_id = 0;                   ///< 1 to 127
  std::shared_ptr<const SlaveDevice> device;  ///< has a CAN connection; never null
  std::optional<std::uint8_t> dip_switch{};   ///< setting of its DIP switch, if that is not the node-ID
};

/// What the simulation and the tools need of a line description with [bus] type = "can".
struct CanLineConfig {
  std::string name = "line";           ///< for messages
  std::string interface = "can0";      ///< the name by which clients of socketcand open the bus
  std::uint32_t bit_rate = 1'000'000;  ///< of the clients' controllers, in bit/s; drives have their own (P 2006)
  slaves::can::Wiring wiring;          ///< cable and terminators
  std::uint64_t seed = 0;              ///< of what happens now and then on the bus
  std::vector<CanNodeConfig> nodes;    ///< in the order along the cable
  std::vector<CanFaultPlan> faults;    ///< in the order of the file
};

/// Whether a line description has [bus] type = "can". False for a pipe, which is not read, and for a file that cannot
/// be read or parsed, which load_line_config() and load_can_line_config() explain.
[[nodiscard]] bool describes_can_line(const std::filesystem::path& file);

/// Returns what the simulation and the tools need of a description. Precondition: it has LineConfig::can.
[[nodiscard]] CanLineConfig can_line_of(const LineConfig& config);

/// Reads the description of a CAN line with load_line_config(). Errors (kFile): place and reason as there; the line is
/// one of EtherCAT.
[[nodiscard]] Result<CanLineConfig> load_can_line_config(const std::filesystem::path& file,
                                                         const DeviceRegistry& devices = DeviceRegistry());
/// Reads it from a text; `name` is for errors, and its folder is where files are looked for.
[[nodiscard]] Result<CanLineConfig> parse_can_line_config(std::string_view text, const std::filesystem::path& name,
                                                          const DeviceRegistry& devices = DeviceRegistry());

}  // namespace driveline::runtime
