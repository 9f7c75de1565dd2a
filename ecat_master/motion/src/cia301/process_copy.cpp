#include "driveline/motion/cia301/process_copy.hpp"

#include <algorithm>

#include "driveline/motion/cia301/pdo_entry.hpp"

namespace driveline::motion {

void apply_copies(std::span<const ProcessDataCopy> copies, std::span<const bool> valid,
                  std::span<const std::byte> inputs, std::span<std::byte> outputs) noexcept {
  for (const auto& copy : copies) {
    if (!valid[copy.from_slave]) continue;
    if (copy.from_bit % 8 == 0 && copy.to_bit % 8 == 0 && copy.bits % 8 == 0) {
      const auto data = inputs.subspan(copy.from_bit / 8, copy.bits / 8);
      std::copy(data.begin(), data.end(), outputs.begin() + static_cast<std::ptrdiff_t>(copy.to_bit / 8));
      continue;
    }
    for (std::size_t done = 0; done < copy.bits;) {
      const auto part = static_cast<unsigned>(std::min<std::size_t>(copy.bits - done, PdoBits::kMaxBits));
      PdoBits(copy.to_bit + done, part).set(outputs, PdoBits(copy.from_bit + done, part).get(inputs));
      done += part;
    }
  }
}

}  // namespace driveline::motion
