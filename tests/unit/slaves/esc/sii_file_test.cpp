// The EEPROM content in a file: a master's changes persist after a restart.
#include <filesystem>
#include <fstream>

#include "bench_slave.hpp"
#include "driveline/slaves/esc/sii_file.hpp"
#include "driveline/wire/sii_access.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::slaves::test {
namespace {

namespace fs = std::filesystem;
namespace sii = wire::sii_access;

class SiiFileTest : public BenchSlave {
 protected:
  [[nodiscard]] fs::path file() const { return folder_.path / "drive.sii"; }
  [[nodiscard]] const fs::path& folder() const { return folder_.path; }
  void write_word(std::uint32_t word, unsigned value) {
    write(0x0508, bytes({value & 0xFF, value >> 8}));
    std::vector<std::byte> data(6);
    bytes::store_le<std::uint16_t>(std::span(data), sii::kCommandWrite | sii::kWriteEnable);
    bytes::store_le(std::span(data).subspan(2), word);
    ASSERT_EQ(write(0x0502, data), 1);
  }

 private:
  driveline::test::TemporaryFolder folder_;
};

TEST_F(SiiFileTest, WithoutAFileTheDeviceHasItsOwnContent) {
  const SiiFile absent(file());
  const auto content = absent.load();
  ASSERT_TRUE(content) << describe(content.error());
  EXPECT_TRUE(content->empty());
}

TEST_F(SiiFileTest, WhatWasWrittenIsThereAtTheNextStart) {
  SiiFile kept(file());
  EXPECT_EQ(kept.save(esc().sii()), false) << "nothing has changed yet";
  EXPECT_FALSE(fs::exists(file()));
  const auto with_alias = test_image(0x0E05, 0x0042);
  write_word(4, 0x0042);
  write_word(7, std::to_integer<unsigned>(with_alias[14]));
  EXPECT_EQ(kept.save(esc().sii()), true);
  EXPECT_EQ(kept.save(esc().sii()), false);

  SlaveOptions options;
  options.sii_image = *SiiFile(file()).load();
  EXPECT_EQ(options.sii_image, with_alias);
  rebuild(options);
  EXPECT_EQ(get(reg::kStationAlias), 0x0042);
}

TEST_F(SiiFileTest, NothingButTheFileIsLeftBehind) {
  SiiFile kept(file());
  write_word(20, 1);
  ASSERT_EQ(kept.save(esc().sii()), true);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder()), fs::directory_iterator()), 1);
}

TEST_F(SiiFileTest, AFailedSaveLeavesTheOldContentAndIsTriedAgain) {
  SiiFile kept(folder() / "absent" / "drive.sii");
  write_word(20, 1);
  EXPECT_EQ(failure_text(kept.save(esc().sii())),
            (folder() / "absent" / "drive.sii").string() + ": cannot be written: No such file or directory");
  fs::create_directory(folder() / "absent");
  EXPECT_EQ(kept.save(esc().sii()), true);
}

TEST_F(SiiFileTest, FilesThatAreNoEepromAreRefused) {
  std::ofstream(file()).close();
  EXPECT_EQ(failure_text(SiiFile(file()).load()),
            file().string() + ": not an EEPROM image: 0 bytes, expected 1 to 131072");
  fs::resize_file(file(), 131073);
  EXPECT_FALSE(SiiFile(file()).load());
  EXPECT_FALSE(SiiFile(folder()).load()) << "a folder";
}

}  // namespace
}  // namespace driveline::slaves::test
