#include "driveline/ecat_master/process_data/pdo_configuration.hpp"

#include <numeric>

namespace driveline::ecat_master {

std::size_t PdoMapping::bits() const noexcept {
  return std::accumulate(objects.begin(), objects.end(), std::size_t{0},
                         [](std::size_t sum, const MappedObject& o) { return sum + o.bits; });
}
std::size_t PdoConfiguration::output_bytes() const noexcept {
  return bytes_of(outputs);
}
std::size_t PdoConfiguration::input_bytes() const noexcept {
  return bytes_of(inputs);
}

std::size_t bytes_of(std::span<const PdoMapping> pdos) noexcept {
  const auto bits = std::accumulate(pdos.begin(), pdos.end(), std::size_t{0},
                                    [](std::size_t sum, const PdoMapping& pdo) { return sum + pdo.bits(); });
  return (bits + 7) / 8;
}

}  // namespace driveline::ecat_master
