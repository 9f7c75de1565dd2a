#include "driveline/runtime/files/output_file.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

#include "driveline/rt/file_descriptor.hpp"
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
  // A limit of the file size stands in for the full disk.
  write(directory / "a", "old");
  const auto previous_reaction = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{1, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto written = write_file(directory / "a", "new");
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, previous_reaction);
  ASSERT_FALSE(written);
  EXPECT_EQ(describe(written.error()), (directory / "a").string() + ": cannot be written: File too large");
  EXPECT_EQ(read(directory / "a"), "old");
  EXPECT_THAT(files(), ElementsAre("a"));
}

TEST_F(OutputFile, APipeIsWrittenInPlace) {
  const auto pipe = directory / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  // Opened for both directions, so that neither side waits for the other.
  const rt::FileDescriptor reader{::open(pipe.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)};
  ASSERT_TRUE(reader.valid());
  ASSERT_TRUE(write_file(pipe, "text"));
  std::array<char, 16> received{};
  EXPECT_EQ(::read(reader.get(), received.data(), received.size()), 4);
  EXPECT_STREQ(received.data(), "text");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  EXPECT_THAT(files(), ElementsAre("pipe"));
}

TEST_F(OutputFile, ADeviceThatIsFullIsToldAndStays) {
  std::filesystem::create_symlink("/dev/full", directory / "full");
  const auto written = write_file(directory / "full", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(describe(written.error()), (directory / "full").string() + ": cannot be written: No space left on device");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  EXPECT_TRUE(std::filesystem::is_symlink(directory / "full"));
  EXPECT_THAT(files(), ElementsAre("full"));
}

TEST_F(OutputFile, ALinkStaysAndItsFileGetsTheContent) {
  std::filesystem::create_directory(directory / "elsewhere");
  write(directory / "elsewhere" / "target", "old");
  std::filesystem::create_symlink("elsewhere/target", directory / "first");
  std::filesystem::create_symlink("first", directory / "second");
  ASSERT_TRUE(write_file(directory / "second", "new"));
  EXPECT_EQ(read(directory / "elsewhere" / "target"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(directory / "first"));
  EXPECT_TRUE(std::filesystem::is_symlink(directory / "second"));
  EXPECT_FALSE(std::filesystem::is_symlink(directory / "elsewhere" / "target"));
  EXPECT_THAT(files(), ElementsAre("elsewhere", "first", "second"));
}

TEST_F(OutputFile, ALinkThatLeadsNowhereIsRefused) {
  std::filesystem::create_symlink("nothing", directory / "link");
  const auto written = write_file(directory / "link", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(describe(written.error()), (directory / "link").string() + ": is a link to a file that does not exist");
  std::filesystem::create_symlink("circle", directory / "circle");
  EXPECT_THAT(describe(write_file(directory / "circle", "text").error()),
              testing::HasSubstr("cannot be written: Too many levels of symbolic links"));
  EXPECT_THAT(files(), ElementsAre("circle", "link"));
}

TEST_F(OutputFile, TheNewFileHasThePermissionsOfTheOldOne) {
  // With the usual umask a new file has neither of these.
  for (const mode_t mode : {0600U, 0666U}) {
    const auto file = directory / "a";
    write(file, "old");
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    ASSERT_TRUE(write_file(file, "new"));
    EXPECT_EQ(static_cast<mode_t>(std::filesystem::status(file).permissions()), mode);
  }
}

TEST_F(OutputFile, APartialNameThatIsTakenLosesNothing) {
  write(directory / "precious", "old");
  std::filesystem::create_symlink("precious", directory / "a.partial");
  ASSERT_EQ(mkfifo((directory / "b.partial").c_str(), 0600), 0);
  EXPECT_FALSE(write_file(directory / "a", "new"));
  EXPECT_FALSE(write_file(directory / "b", "new"));
  EXPECT_EQ(read(directory / "precious"), "old");
  EXPECT_THAT(files(), ElementsAre("a.partial", "b.partial", "precious"));
}

TEST_F(OutputFile, AnOpenDescriptorIsWrittenInPlace) {
  write(directory / "stdout", "old and longer");
  const rt::FileDescriptor open{::open((directory / "stdout").c_str(), O_RDONLY | O_CLOEXEC)};
  ASSERT_TRUE(open.valid());
  const auto name = "/proc/self/fd/" + std::to_string(open.get());
  std::filesystem::create_symlink(name, directory / "link");
  ASSERT_TRUE(write_file(directory / "link", "new"));
  std::array<char, 16> content{};
  EXPECT_EQ(::read(open.get(), content.data(), content.size()), 3) << "the descriptor sees the new content";
  EXPECT_THAT(files(), ElementsAre("link", "stdout"));
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
