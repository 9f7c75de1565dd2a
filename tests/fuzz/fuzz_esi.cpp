// ESI files.

#include <string>

#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {

void test_one_input(std::span<const std::byte> input) {
  std::string text;
  for (const auto byte : input) text += static_cast<char>(byte);
  const auto file = esi::read_esi(text, "input.xml");
  if (file) static_cast<void>(esi::write_esi(file->devices));
}

std::vector<Bytes> seeds() {
  Bytes seed;
  auto device = slaves::msd::device_description();
  // A few objects of each kind are enough; the whole dictionary would only make the fuzzer slow.
  if (device.objects.size() > 6) device.objects.resize(6);
  for (const char c : esi::write_esi({device})) seed.push_back(static_cast<std::byte>(c));
  return {seed};
}

}  // namespace driveline::fuzz
