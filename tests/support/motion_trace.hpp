#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>

namespace driveline {

/// Digest of all values of a motion, for scripts/same_motion.sh, which compares two builds. At its end it appends a
/// line with the test, the number of values and their digest to the file that DRIVELINE_MOTION_TRACE names; without
/// that variable it does nothing.
class MotionTrace {
 public:
  /// Adds values, bit for bit.
  template <typename... Values>
  void add(Values... values) {
    if (digest_) (digest_->add(std::bit_cast<std::uint64_t>(static_cast<double>(values))), ...);
  }
  void add_bytes(std::span<const std::byte> bytes) {
    if (!digest_) return;
    for (const auto byte : bytes) digest_->add(std::to_integer<std::uint64_t>(byte));
  }

 private:
  struct Digest {
    Digest() = default;
    Digest(const Digest&) = delete;
    Digest& operator=(const Digest&) = delete;
    ~Digest() {
      const auto* test = testing::UnitTest::GetInstance()->current_test_info();
      std::FILE* file = test == nullptr || count == 0 ? nullptr : std::fopen(std::getenv(kVariable), "a");
      if (file == nullptr) return;
      std::fprintf(file, "%s.%s %llu %016llx\n", test->test_suite_name(), test->name(),
                   static_cast<unsigned long long>(count), static_cast<unsigned long long>(hash));
      std::fclose(file);
    }
    /// FNV-1a over words.
    void add(std::uint64_t value) {
      hash = (hash ^ value) * 0x100000001B3ULL;
      hash ^= hash >> 29;
      ++count;
    }
    std::uint64_t hash = 0xCBF29CE484222325ULL;
    std::uint64_t count = 0;
  };
  static constexpr const char* kVariable = "DRIVELINE_MOTION_TRACE";

  std::unique_ptr<Digest> digest_ = std::getenv(kVariable) == nullptr ? nullptr : std::make_unique<Digest>();
};

}  // namespace driveline
