// Runs a fuzz target without a fuzzer: the seeds, all their truncations up to a limit, and seeded random mutations.
//   <target> [--mutations N] [--write DIR] [FILE ...]
// --write stores the seeds for a fuzzer's corpus; FILEs are inputs of former findings.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "fuzz_target.hpp"

namespace {

using driveline::fuzz::Bytes;

constexpr std::uint64_t kSeed = 20'061'985;
constexpr std::size_t kMaxTruncations = 512;

void write_seeds(const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  std::size_t number = 0;
  for (const auto& seed : driveline::fuzz::seeds()) {
    std::ofstream file(directory / ("seed-" + std::to_string(number++)), std::ios::binary);
    for (const auto byte : seed) file.put(static_cast<char>(byte));
  }
}

Bytes read_file(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", name.c_str());
    std::exit(2);
  }
  Bytes bytes;
  for (std::istreambuf_iterator<char> it(file), end; it != end; ++it) bytes.push_back(static_cast<std::byte>(*it));
  return bytes;
}

/// A typical corruption: flipped bits, extreme values, missing, repeated or foreign bytes.
Bytes mutate(Bytes bytes, std::mt19937_64& random) {
  const auto changes = 1 + random() % 6;
  for (std::uint64_t i = 0; i < changes && !bytes.empty(); ++i) {
    const auto at = static_cast<std::ptrdiff_t>(random() % bytes.size());
    const auto here = bytes.begin() + at;
    switch (random() % 6) {
      case 0:
        *here ^= static_cast<std::byte>(1U << (random() % 8));
        break;
      case 1:
        *here = static_cast<std::byte>(random() % 2 == 0 ? 0xFF : 0x00);
        break;
      case 2:
        *here = static_cast<std::byte>(random());
        break;
      case 3:
        bytes.erase(here);
        break;
      case 4:
        bytes.insert(here, static_cast<std::byte>(random()));
        break;
      default:
        bytes.resize(static_cast<std::size_t>(at));
        break;
    }
  }
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t mutations = 5000;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--write" && i + 1 < argc) {
      write_seeds(argv[++i]);
      return 0;
    }
    if (argument == "--mutations" && i + 1 < argc) {
      mutations = std::strtoull(argv[++i], nullptr, 10);
    } else {
      driveline::fuzz::test_one_input(read_file(argument));
    }
  }
  const auto seeds = driveline::fuzz::seeds();
  std::mt19937_64 random(kSeed);
  std::size_t runs = 0;
  for (const auto& seed : seeds) {
    driveline::fuzz::test_one_input(seed);
    for (std::size_t length = 0; length < std::min(seed.size(), kMaxTruncations); ++length, ++runs) {
      driveline::fuzz::test_one_input(std::span(seed).first(length));
    }
  }
  for (std::uint64_t i = 0; i < mutations; ++i, ++runs) {
    driveline::fuzz::test_one_input(mutate(seeds[random() % seeds.size()], random));
  }
  std::printf("%zu seeds, %zu truncations and mutations\n", seeds.size(), runs);
  return seeds.empty() ? 1 : 0;
}
