#include "driveline/motion/cia402/object_name.hpp"

#include <algorithm>
#include <array>

namespace driveline::motion::cia402 {
namespace {

struct Row {
  std::uint16_t index;
  std::string_view name;
};

constexpr std::array kObjects{
    Row{0x603F, "Error code"},
    Row{0x6040, "Controlword"},
    Row{0x6041, "Statusword"},
    Row{0x6042, "vl target velocity"},
    Row{0x6043, "vl velocity demand"},
    Row{0x6044, "vl velocity actual value"},
    Row{0x6060, "Modes of operation"},
    Row{0x6061, "Modes of operation display"},
    Row{0x6062, "Position demand value"},
    Row{0x6063, "Position actual internal value"},
    Row{0x6064, "Position actual value"},
    Row{0x606B, "Velocity demand value"},
    Row{0x606C, "Velocity actual value"},
    Row{0x6071, "Target torque"},
    Row{0x6072, "Max torque"},
    Row{0x6074, "Torque demand"},
    Row{0x6077, "Torque actual value"},
    Row{0x6078, "Current actual value"},
    Row{0x6079, "DC link circuit voltage"},
    Row{0x607A, "Target position"},
    Row{0x607F, "Max profile velocity"},
    Row{0x6081, "Profile velocity"},
    Row{0x6083, "Profile acceleration"},
    Row{0x6084, "Profile deceleration"},
    Row{0x6087, "Torque slope"},
    Row{0x60B0, "Position offset"},
    Row{0x60B1, "Velocity offset"},
    Row{0x60B2, "Torque offset"},
    Row{0x60B8, "Touch probe function"},
    Row{0x60B9, "Touch probe status"},
    Row{0x60BA, "Touch probe 1 positive edge"},
    Row{0x60BB, "Touch probe 1 negative edge"},
    Row{0x60BC, "Touch probe 2 positive edge"},
    Row{0x60BD, "Touch probe 2 negative edge"},
    Row{0x60E0, "Positive torque limit value"},
    Row{0x60E1, "Negative torque limit value"},
    Row{0x60F4, "Following error actual value"},
    Row{0x60FA, "Control effort"},
    Row{0x60FC, "Position demand internal value"},
    Row{0x60FD, "Digital inputs"},
    Row{0x60FF, "Target velocity"},
};

}  // namespace

std::string_view object_name(std::uint16_t index, std::uint8_t subindex) noexcept {
  // Devices of other profiles have other objects at these indices, all of them with sub-indices.
  if (index == 0x60C1 && subindex == 1) return "Interpolation data record";
  if (subindex != 0) return {};
  const auto row =
      std::find_if(kObjects.begin(), kObjects.end(), [index](const Row& object) { return object.index == index; });
  return row == kObjects.end() ? std::string_view{} : row->name;
}

}  // namespace driveline::motion::cia402
