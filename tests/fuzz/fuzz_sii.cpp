// EEPROM images. What decodes must encode to the same bytes.

#include <algorithm>

#include "driveline/esi/sii.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {

void test_one_input(std::span<const std::byte> input) {
  const auto image = esi::decode_sii(input);
  if (!image) {
    static_cast<void>(esi::to_text(image.error()));
    return;
  }
  const auto encoded = esi::encode_sii(*image);
  if (!std::equal(encoded.begin(), encoded.end(), input.begin(), input.end())) std::abort();
  static_cast<void>(esi::description_from_sii(*image));
}

std::vector<Bytes> seeds() {
  return {esi::encode_sii(esi::make_sii(slaves::msd::device_description()))};
}

}  // namespace driveline::fuzz
