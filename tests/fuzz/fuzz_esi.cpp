// ESI files. A description must be writable and run as a device, or be refused with a reason.

#include <cstdlib>
#include <string>

#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "fuzz_seeds.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

void run(const std::shared_ptr<const slaves::generic::DeviceModel>& model) {
  slaves::generic::GenericDevice device(model, {});
  static_cast<void>(device.transition(wire::AlState::kInit, wire::AlState::kPreOp));
  static_cast<void>(device.transition(wire::AlState::kPreOp, wire::AlState::kSafeOp));
  for (std::size_t n = 0; n < device.profile().sync_managers.size(); ++n) {
    std::vector<std::byte> data(device.process_data_size(n), std::byte{0x5A});
    device.write_outputs(n, data);
    device.read_inputs(n, data);
  }
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  std::string text;
  for (const auto byte : input) text += static_cast<char>(byte);
  const auto file = esi::read_esi(text, "input.xml");
  if (!file) {
    if (esi::to_text(file.error()).empty()) std::abort();
    return;
  }
  static_cast<void>(esi::write_esi(file->devices));
  for (const auto& device : file->devices) {
    const auto model = slaves::generic::DeviceModel::create(device);
    if (!model && describe(model.error()).empty()) std::abort();
    if (model) run(*model);
  }
}

std::vector<Bytes> seeds() {
  Bytes seed;
  auto device = slaves::msd::device_description();
  // A few objects of each kind are sufficient; the whole dictionary would only slow down the fuzzer.
  if (device.objects.size() > 6) device.objects.resize(6);
  for (const char c : esi::write_esi({device})) seed.push_back(static_cast<std::byte>(c));
  Bytes examples;
  for (const char c : example_devices()) examples.push_back(static_cast<std::byte>(c));
  return {seed, examples};
}

}  // namespace driveline::fuzz
