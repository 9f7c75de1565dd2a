// The request for processors that stay awake, on files that behave like the kernel's device or differ from it.
#include "driveline/rt/cpu_latency.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <limits>

namespace driveline::rt {
namespace {

using std::chrono::microseconds;

/// How many descriptors of this process refer to `file`.
int open_handles(const std::string& file) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(entry.path(), gone) == file) ++count;
  }
  return count;
}

/// An ordinary file: it stores the written value like the device, and never requests more.
class CpuLatency : public testing::Test {
 protected:
  CpuLatency() { std::ofstream(device).put('\0'); }
  ~CpuLatency() override { std::filesystem::remove(device); }
  [[nodiscard]] std::int32_t written() const {
    std::int32_t value = -1;
    std::ifstream(device, std::ios::binary).read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }
  const std::string device = std::filesystem::canonical(std::filesystem::temp_directory_path()) /
                             ("driveline-cpu-latency-" + std::to_string(getpid()));
};

TEST_F(CpuLatency, IsHeldUntilItsOwnerIsGone) {
  {
    CpuLatencyHold hold;
    EXPECT_EQ(open_handles(device), 0) << "nobody has asked yet";
    const auto item = hold.request(microseconds{7000}, device);
    EXPECT_TRUE(item.ok);
    EXPECT_EQ(item.requested, "at most 7000 us");
    EXPECT_EQ(item.effective, "at most 7000 us");
    EXPECT_EQ(written(), 7000);
    EXPECT_EQ(open_handles(device), 1);
  }
  EXPECT_EQ(open_handles(device), 0);
}

TEST_F(CpuLatency, ASecondRequestTakesThePlaceOfTheFirst) {
  CpuLatencyHold hold;
  EXPECT_TRUE(hold.request(microseconds{20}, device).ok);
  EXPECT_TRUE(hold.request(microseconds{5}, device).ok);
  EXPECT_EQ(written(), 5);
  EXPECT_EQ(open_handles(device), 1);
  hold.release();
  EXPECT_EQ(open_handles(device), 0);
  hold.release();
}

TEST_F(CpuLatency, LimitsBeyondWhatTheKernelTakesAreTheNearestItDoes) {
  CpuLatencyHold hold;
  EXPECT_TRUE(hold.request(microseconds{-3}, device).ok);
  EXPECT_EQ(written(), 0);
  EXPECT_TRUE(hold.request(microseconds::max(), device).ok);
  EXPECT_EQ(written(), std::numeric_limits<std::int32_t>::max());
}

TEST_F(CpuLatency, WhatCannotBeWrittenOrReadBackIsNotInEffectAndNotHeld) {
  CpuLatencyHold hold;
  const auto full = hold.request(microseconds{0}, "/dev/full");
  EXPECT_FALSE(full.ok);
  EXPECT_EQ(full.error_number, ENOSPC);
  EXPECT_EQ(full.effective, "left to the kernel");
  EXPECT_NE(full.remedy, "");
  EXPECT_EQ(open_handles("/dev/full"), 0);
  const auto mute = hold.request(microseconds{0}, "/dev/null");
  EXPECT_FALSE(mute.ok) << "it takes everything and says nothing";
  EXPECT_EQ(mute.effective, "left to the kernel");
}

}  // namespace
}  // namespace driveline::rt
