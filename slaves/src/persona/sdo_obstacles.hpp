#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/persona/persona.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::slaves {

/// An SDO transfer that a persona refuses.
struct SdoRefusal {
  wire::SdoHeader request;       ///< as received
  std::uint32_t abort_code = 0;  ///< why
};

/// Refuses SDO transfers according to the personas of a device. Not thread-safe.
class SdoObstacles {
 public:
  /// Copies the personas that concern the object dictionary.
  explicit SdoObstacles(std::span<const Persona> personas);

  /// Returns the refusal of a mailbox message, header included; none: the device gets it.
  [[nodiscard]] std::optional<SdoRefusal> refuse(std::span<const std::byte> mail) const;

 private:
  std::vector<Persona> personas_;
};

}  // namespace driveline::slaves
