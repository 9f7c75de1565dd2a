#include "driveline/runtime/files/output_file.hpp"

#include <gmock/gmock.h>

#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using testing::ElementsAre;

class OutputFile : public test::TemporaryDirectory {};

TEST_F(OutputFile, ReplacesWhatWasThere) {
  write(directory / "a", "old and longer");
  EXPECT_TRUE(write_file(directory / "a", std::string_view("new\0", 4)));
  EXPECT_EQ(read(directory / "a"), std::string("new\0", 4));
  EXPECT_THAT(files(), ElementsAre("a"));
}

TEST_F(OutputFile, FolderThatIsNotThere) {
  const auto file = directory / "none" / "a";
  EXPECT_EQ(describe(write_file(file, "text").error()),
            file.string() + ": cannot be written: No such file or directory");
}

TEST_F(OutputFile, NameThatIsTakenLosesNothingAndLeavesNothing) {
  std::filesystem::create_directories(directory / "a" / "b");
  const auto file = directory / "a";
  EXPECT_EQ(describe(write_file(file, "text").error()), file.string() + ": cannot be written: Is a directory");
  EXPECT_THAT(files(), ElementsAre("a"));
  EXPECT_TRUE(std::filesystem::exists(directory / "a" / "b"));
}

TEST_F(OutputFile, FullDiskLeavesTheOldFile) {
  // Everything written to the partial file goes to /dev/full.
  write(directory / "a", "old");
  std::filesystem::create_symlink("/dev/full", directory / "a.partial");
  const auto written = write_file(directory / "a", "new");
  ASSERT_FALSE(written);
  EXPECT_EQ(describe(written.error()), (directory / "a").string() + ": cannot be written: No space left on device");
  EXPECT_EQ(read(directory / "a"), "old");
  EXPECT_THAT(files(), ElementsAre("a"));
}

TEST_F(OutputFile, AFolderIsOneProgramsAtATime) {
  {
    const auto first = FolderLock::take(directory);
    ASSERT_TRUE(first) << describe(first.error());
    const auto second = FolderLock::take(directory);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::kFolderBusy);
    EXPECT_EQ(describe(second.error()), directory.string() + ": another run is writing into this folder");
    EXPECT_THAT(files(), ElementsAre());
  }
  EXPECT_TRUE(FolderLock::take(directory)) << "it is free again";
}

}  // namespace
}  // namespace driveline::runtime
