#include "driveline/motion/cia301/pdo_configuration.hpp"

#include <algorithm>
#include <numeric>

namespace driveline::motion {

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

bool same_content(std::span<const MappedObject> a, std::span<const MappedObject> b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const MappedObject& x, const MappedObject& y) {
    return x.index == y.index && x.bits == y.bits && (x.index == 0 || x.subindex == y.subindex);
  });
}

bool same_pdos(std::span<const PdoMapping> planned, std::span<const PdoMapping> present) noexcept {
  return std::equal(planned.begin(), planned.end(), present.begin(), present.end(),
                    [](const PdoMapping& plan, const PdoMapping& own) {
                      if (plan.index != own.index) return false;
                      return plan.objects.empty() || plan.own_mapping || same_content(plan.objects, own.objects);
                    });
}

std::size_t bytes_of(std::span<const PdoMapping> pdos) noexcept {
  const auto bits = std::accumulate(pdos.begin(), pdos.end(), std::size_t{0},
                                    [](std::size_t sum, const PdoMapping& pdo) { return sum + pdo.bits(); });
  return (bits + 7) / 8;
}

}  // namespace driveline::motion
