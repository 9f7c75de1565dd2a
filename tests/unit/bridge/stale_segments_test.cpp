// Shared memory segments that a bridge removes before it creates its own.
#include "stale_segments.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "support/temporary_directory.hpp"

namespace driveline::bridge {
namespace {

class StaleSegments : public test::TemporaryDirectory {
 protected:
  void make(const std::string& name) { std::ofstream{directory / name} << "x"; }
  [[nodiscard]] bool there(const std::string& name) const { return std::filesystem::exists(directory / name); }
};

TEST_F(StaleSegments, OfTheDeadAreRemovedWithTheirLocks) {
  make("fastrtps_0123456789abcdef");
  make("fastrtps_0123456789abcdef_el");
  EXPECT_EQ(remove_stale_segments(directory), 1U);
  EXPECT_FALSE(there("fastrtps_0123456789abcdef"));
  EXPECT_FALSE(there("fastrtps_0123456789abcdef_el"));
}

TEST_F(StaleSegments, OfTheLivingStay) {
  make("fastrtps_0123456789abcdef");
  make("fastrtps_0123456789abcdef_el");
  const int held = ::open((directory / "fastrtps_0123456789abcdef_el").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(::flock(held, LOCK_EX | LOCK_NB), 0);
  EXPECT_EQ(remove_stale_segments(directory), 0U);
  EXPECT_TRUE(there("fastrtps_0123456789abcdef"));
  EXPECT_TRUE(there("fastrtps_0123456789abcdef_el"));
  ::close(held);
}

TEST_F(StaleSegments, AndNothingElseIsTouched) {
  const std::string others[] = {"fastrtps_port7410",
                                "fastrtps_port7410_el",
                                "fastrtps_0123456789abcdeg",
                                "fastrtps_0123456789abcdef",
                                "fastrtps_0123456789abcde_el",
                                "sem.fastrtps_port7410_mutex",
                                "somebody_elses"};
  for (const auto& name : others) make(name);
  std::filesystem::create_symlink(directory / "somebody_elses", directory / "fastrtps_00000000000000aa");
  make("fastrtps_00000000000000aa_el");
  EXPECT_EQ(remove_stale_segments(directory), 0U) << "one without a lock is not yet whole, or of another version";
  for (const auto& name : others) EXPECT_TRUE(there(name)) << name;
  EXPECT_TRUE(there("fastrtps_00000000000000aa"));
  EXPECT_EQ(remove_stale_segments(directory / "nowhere"), 0U);
}

}  // namespace
}  // namespace driveline::bridge
