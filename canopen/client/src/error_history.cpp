#include "driveline/canopen_client/error_history.hpp"

namespace driveline::canopen {

ClientResult<std::vector<HistoricError>> read_error_history(SdoClient& client) {
  constexpr std::uint16_t kHistory = 0x1003;
  constexpr std::uint32_t kMost = 254;  ///< entries of an array
  const auto count = client.upload_number({kHistory, 0});
  if (!count) return tl::unexpected(count.error());
  std::vector<HistoricError> errors;
  for (std::uint32_t i = 1; i <= *count && i <= kMost; ++i) {
    const auto value = client.upload_number({kHistory, static_cast<std::uint8_t>(i)});
    if (!value) return tl::unexpected(value.error());
    errors.push_back({static_cast<std::uint16_t>(*value), static_cast<std::uint16_t>(*value >> 16U)});
  }
  return errors;
}

}  // namespace driveline::canopen
