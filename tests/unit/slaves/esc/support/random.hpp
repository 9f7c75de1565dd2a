#pragma once

#include <random>

namespace driveline::slaves::test {

/// Random 32-bit numbers, the same on every machine for the same seed.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  unsigned operator()() { return static_cast<unsigned>(engine_()); }

 private:
  std::mt19937 engine_;
};

}  // namespace driveline::slaves::test
