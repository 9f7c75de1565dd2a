#include "driveline/slaves/mc7000/process_values.hpp"

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves::mc7000 {
namespace {

constexpr std::byte kWriteVariable{0xF0};
constexpr std::byte kWriteFlag{0x0F};
constexpr std::byte kWriteBoth{0xFF};

}  // namespace

PosModLocation ProcessValues::receive_rx_pdo21(std::span<const std::byte, kRxPdo21Size> pdo) noexcept {
  const bool variable = pdo[0] == kWriteVariable || pdo[0] == kWriteBoth;
  const bool flag = pdo[0] == kWriteFlag || pdo[0] == kWriteBoth;
  const auto variable_field = std::to_integer<std::size_t>(pdo[1]);
  const auto flag_field = std::to_integer<std::size_t>(pdo[6]);
  if ((variable && variable_field >= kFields) || (flag && flag_field >= kFields)) return PosModLocation::kIndexOverflow;
  if (variable) set_variable(variable_field, bytes::load_le<std::int32_t>(pdo.subspan<2, 4>()));
  if (flag) set_flag(flag_field, std::to_integer<std::uint8_t>(pdo[7]));
  return PosModLocation::kNone;
}

}  // namespace driveline::slaves::mc7000
