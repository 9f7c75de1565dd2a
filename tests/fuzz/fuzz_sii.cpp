// EEPROM images. A decoded image must encode to the same bytes, and run as a device or be refused with a reason.

#include <algorithm>
#include <cstdlib>

#include "driveline/esi/sii.hpp"
#include "driveline/slaves/esc/slave.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "fuzz_seeds.hpp"
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
  const auto model = slaves::generic::DeviceModel::create(esi::description_from_sii(*image));
  if (!model) {
    if (describe(model.error()).empty()) std::abort();
    return;
  }
  slaves::generic::GenericOptions options;
  options.sii_image.assign(input.begin(), input.end());
  slaves::Slave slave(std::make_unique<slaves::generic::GenericDevice>(*model, options));
  slave.advance(std::chrono::milliseconds{1});
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> inputs = recorded_images();
  inputs.push_back(esi::encode_sii(esi::make_sii(slaves::msd::device_description())));
  inputs.push_back(esi::encode_sii(esi::make_sii(example_device("MX4"))));
  return inputs;
}

}  // namespace driveline::fuzz
