#pragma once

#include <vector>

#include "driveline/canopen_client/sdo_client.hpp"

namespace driveline::canopen {

/// An entry of object 1003h: emergency error code in the lower half, manufacturer-specific in the upper one.
struct HistoricError {
  std::uint16_t code = 0;          ///< emergency error code
  std::uint16_t manufacturer = 0;  ///< additional information
  constexpr bool operator==(const HistoricError&) const = default;
};

/// Reads the errors that a node remembers in object 1003h, the newest first. Errors: those of SdoClient::upload();
/// kAborted with kObjectDoesNotExist: the node has no history.
[[nodiscard]] ClientResult<std::vector<HistoricError>> read_error_history(SdoClient& client);

}  // namespace driveline::canopen
