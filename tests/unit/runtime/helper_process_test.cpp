#include "helper/helper_process.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <fstream>
#include <optional>
#include <thread>

namespace driveline::runtime {
namespace {

TEST(HelperProcess, IsWhatTheKernelEndsFirstWhenMemoryRunsOut) {
  const auto helper = HelperProcess::start("/bin/sleep", {"600"});
  ASSERT_TRUE(helper) << describe(helper.error());
  std::ifstream file(fmt::format("/proc/{}/oom_score_adj", helper->id()));
  int adjustment = 0;
  ASSERT_TRUE(file >> adjustment);
  EXPECT_EQ(adjustment, 1000);
}

TEST(HelperProcess, StartsInAProcessThatMayOpenFewFiles) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  auto fewer = before;
  fewer.rlim_cur = 40;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &fewer), 0);
  const std::array passed{STDERR_FILENO, STDERR_FILENO, STDERR_FILENO};
  // The last one has number 6 there.
  auto helper = HelperProcess::start("/bin/sh", {"-c", "test -e /proc/self/fd/6"}, passed);
  ::setrlimit(RLIMIT_NOFILE, &before);
  ASSERT_TRUE(helper) << describe(helper.error());
  std::optional<int> status;
  while (!(status = helper->reap())) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  EXPECT_EQ(describe_end(*status), "status 0");
}

}  // namespace
}  // namespace driveline::runtime
