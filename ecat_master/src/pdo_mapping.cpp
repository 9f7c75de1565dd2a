#include "driveline/ecat_master/pdo_mapping.hpp"

#include <numeric>

namespace driveline::ecat_master {
namespace {

constexpr std::uint16_t kOutputAssignment = 0x1C12;
constexpr std::uint16_t kInputAssignment = 0x1C13;

std::size_t bytes_of(const std::vector<PdoMapping>& pdos) {
  const auto bits = std::accumulate(pdos.begin(), pdos.end(), std::size_t{0},
                                    [](std::size_t sum, const PdoMapping& pdo) { return sum + pdo.bits(); });
  return (bits + 7) / 8;
}

/// Writes a list object the way CANopen wants it: count 0, elements, count.
template <typename T, typename Elements, typename Raw>
Result<void> write_list(CoeClient& coe, std::uint16_t index, const Elements& elements, Raw raw) {
  if (auto done = coe.download_as<std::uint8_t>(index, 0, 0); !done) return done;
  std::uint8_t subindex = 0;
  for (const auto& element : elements) {
    if (auto done = coe.download_as<T>(index, ++subindex, raw(element)); !done) return done;
  }
  return coe.download_as<std::uint8_t>(index, 0, subindex);
}

Result<void> write_direction(CoeClient& coe, std::uint16_t assignment, const std::vector<PdoMapping>& pdos) {
  if (auto done = coe.download_as<std::uint8_t>(assignment, 0, 0); !done) return done;
  for (const auto& pdo : pdos) {
    auto done = write_list<std::uint32_t>(coe, pdo.index, pdo.objects, [](const MappedObject& o) { return o.raw(); });
    if (!done) return done;
  }
  return write_list<std::uint16_t>(coe, assignment, pdos, [](const PdoMapping& pdo) { return pdo.index; });
}

}  // namespace

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

Result<void> write_pdo_configuration(CoeClient& coe, const PdoConfiguration& configuration) {
  if (auto done = write_direction(coe, kOutputAssignment, configuration.outputs); !done) return done;
  return write_direction(coe, kInputAssignment, configuration.inputs);
}

Result<std::size_t> read_assigned_bytes(CoeClient& coe, std::uint16_t assignment) {
  const auto pdos = coe.upload_as<std::uint8_t>(assignment, 0);
  if (!pdos) return tl::unexpected(pdos.error());
  std::size_t bits = 0;
  for (unsigned i = 1; i <= *pdos; ++i) {
    const auto pdo = coe.upload_as<std::uint16_t>(assignment, static_cast<std::uint8_t>(i));
    if (!pdo) return tl::unexpected(pdo.error());
    const auto objects = coe.upload_as<std::uint8_t>(*pdo, 0);
    if (!objects) return tl::unexpected(objects.error());
    for (unsigned k = 1; k <= *objects; ++k) {
      const auto entry = coe.upload_as<std::uint32_t>(*pdo, static_cast<std::uint8_t>(k));
      if (!entry) return tl::unexpected(entry.error());
      bits += *entry & 0xFFU;
    }
  }
  return (bits + 7) / 8;
}

}  // namespace driveline::ecat_master
