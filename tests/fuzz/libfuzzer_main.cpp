#include "fuzz_target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  driveline::fuzz::test_one_input(std::as_bytes(std::span(data, size)));
  return 0;
}
