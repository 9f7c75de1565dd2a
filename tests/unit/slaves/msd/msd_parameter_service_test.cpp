// Saving, factory settings, download without logic check, parameter file, start-up (MSD manual 7.5, 8.2.5).
#include <filesystem>
#include <fstream>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

TEST(MsdParameterService, SaveCommandResetsItselfWhenTheDataAreSaved) {
  MsdParameters parameters;
  parameters.save_time = 20ms;
  DriveRig rig(parameters);
  ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  rig.pass(19ms);
  EXPECT_EQ(rig.read(0x200B, 1), 1U);
  rig.pass(2ms);
  EXPECT_EQ(rig.read(0x200B, 1), 0U);
}

TEST(MsdParameterService, StartTakesItsTimeAndLongerAfterAFactoryReset) {
  MsdParameters parameters;
  parameters.start_up_time = 30ms;
  DriveRig rig(parameters);
  const auto time_to_ready = [&] {
    rig.restart();
    std::chrono::milliseconds time{0};
    while (rig.drive.state() == PowerState::kNotReadyToSwitchOn && time < 20s) {
      rig.pass(1ms);
      time += 1ms;
    }
    return time;
  };
  EXPECT_NEAR(static_cast<double>(time_to_ready().count()), 30.0, 1.0);
  rig.set({{0x200B, 3, 1, 1}, {0x200B, 1, 1, 1}});
  EXPECT_NEAR(static_cast<double>(time_to_ready().count()), 10000.0, 1.0) << "what the manual says, unless set";
  EXPECT_NEAR(static_cast<double>(time_to_ready().count()), 30.0, 1.0) << "once";
  parameters.factory_start_up_time = 500ms;
  DriveRig quick(parameters);
  quick.set({{0x200B, 3, 1, 1}, {0x200B, 1, 1, 1}});
  quick.restart();
  quick.pass(400ms);
  EXPECT_EQ(quick.read(0x280C), 0U) << "boot-up";
  EXPECT_EQ(quick.drive.state(), PowerState::kNotReadyToSwitchOn);
  quick.pass(110ms);
  EXPECT_EQ(quick.drive.state(), PowerState::kSwitchOnDisabled);
}

TEST(MsdParameterService, LogicCheckRefusesWhatDoesNotFitTheDataSet) {
  DriveRig rig;
  EXPECT_EQ(rig.write(0x607D, 1, 5000, 4), 0x06040043U) << "minimum above the maximum of 0";
  rig.set({{0x607D, 2, 9000, 4}, {0x607D, 1, 5000, 4}});
  EXPECT_EQ(rig.write(0x607D, 2, static_cast<std::uint32_t>(-1), 4), 0x06040043U);
  EXPECT_EQ(rig.write(0x6046, 1, 40000, 4), 0x06040043U);
  EXPECT_EQ(rig.write(0x607B, 2, static_cast<std::uint32_t>(-5), 4), 0x06040043U);
}

TEST(MsdParameterService, DownloadWithoutLogicCheckTakesAnyOrder) {
  DriveRig rig;
  rig.set({{0x200B, 4, 1, 1}, {0x607D, 1, 5000, 4}});
  EXPECT_EQ(rig.write(0x605A, 0, 9, 2), 0x06090031U) << "ranges are checked all the same";
  rig.set({{0x607D, 2, 9000, 4}, {0x200B, 4, 0, 1}});
  rig.pass(5ms);
  EXPECT_FALSE(rig.drive.fault().has_value());
  EXPECT_EQ(rig.write(0x607D, 2, 4000, 4), 0x06040043U) << "the check is on again";
}

TEST(MsdParameterService, InconsistentDownloadEndsInAnEmergencyAndEr0205) {
  DriveRig rig;
  rig.set({{0x200B, 4, 1, 1}, {0x607D, 1, 5000, 4}, {0x200B, 4, 0, 1}});
  rig.pass(5ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kParameterList);
  EXPECT_EQ(rig.drive.display(), "Er. 02 05");
  rig.fetch_emergencies();
  EXPECT_THAT(rig.emergencies, testing::ElementsAre(testing::ElementsAre(0x20, 0x63, 0x21, 2, 5, 0, 0, 0)));
  rig.set({{0x607D, 1, 0, 4}, {0x2099, 0, 1, 1}});
  rig.pass(5ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
}

TEST(MsdParameterService, DownloadNeedsStandstillWithPowerOffAndKeepsThePowerOff) {
  OperatingRig rig;
  rig.run_at(5'000'000);
  EXPECT_EQ(rig.write(0x200B, 4, 1, 1), 0x08000022U);
  rig.command(0x00, 4);  // coasting
  EXPECT_EQ(rig.write(0x200B, 4, 1, 1), 0x08000022U);
  rig.cycles(8000);
  EXPECT_EQ(rig.write(0x200B, 4, 1, 1), 0U);
  rig.command(0x06, 4);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  ASSERT_EQ(rig.write(0x200B, 4, 0, 1), 0U);
  rig.cycles(4);
  EXPECT_EQ(rig.drive.state(), PowerState::kReadyToSwitchOn);
}

class MsdParameterFile : public testing::Test {
 protected:
  MsdParameterFile() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(testing::TempDir()) / (std::string("driveline_") + test->name() + ".txt");
    std::filesystem::remove(path_);
    parameters_.parameter_file = path_.string();
  }
  ~MsdParameterFile() override { std::filesystem::remove(path_); }
  [[nodiscard]] std::string content() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write_content(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }
  std::filesystem::path path_;
  MsdParameters parameters_;
};

TEST_F(MsdParameterFile, KeepsStoredParametersForTheNextDrive) {
  {
    DriveRig rig(parameters_);
    rig.set({{0x605A, 0, 6, 2}, real_value(0x2132, 0, 0.125F), {0x607C, 0, static_cast<std::uint32_t>(-77), 4}});
    rig.map(0x1600, {0x60400010});
    ASSERT_EQ(rig.write(0x6060, 0, 8, 1), 0U);
    EXPECT_FALSE(std::filesystem::exists(path_)) << "nothing is saved unasked";
    ASSERT_EQ(rig.write(0x1010, 1, 0x65766173, 4), 0U);
  }
  EXPECT_NE(content().find("605A:00 = 6  # Quick stop option code\n"), std::string::npos);
  EXPECT_NE(content().find("2003:00 = \"X-Axis\""), std::string::npos);
  EXPECT_EQ(content().find("6060"), std::string::npos) << "not storable";
  EXPECT_FALSE(std::filesystem::exists(path_.string() + ".partial"));
  DriveRig next(parameters_);
  EXPECT_EQ(next.read(0x605A), 6U);
  EXPECT_EQ(next.read(0x607C), static_cast<std::uint32_t>(-77));
  EXPECT_EQ(std::bit_cast<float>(next.read(0x2132)), 0.125F);
  EXPECT_EQ(next.read(0x1600), 1U);
  EXPECT_EQ(next.device.process_data_size(2), 2U);
}

TEST_F(MsdParameterFile, FactoryResetIsSavedToo) {
  DriveRig rig(parameters_);
  rig.set({{0x605A, 0, 6, 2}, {0x200B, 1, 1, 1}, {0x200B, 3, 1, 1}, {0x200B, 1, 1, 1}});
  EXPECT_NE(content().find("605A:00 = 2  #"), std::string::npos);
}

TEST_F(MsdParameterFile, ABrokenFileIsFault0205WithItsLineAndFactorySettings) {
  struct Case {
    std::string line;
    std::string what;
  };
  for (const auto& c :
       {Case{"605A:00 = 99", "out of range"}, Case{"605A:00 = six", "whole number"},
        Case{"6041:00 = 1", "not a stored parameter"}, Case{"5FFF:00 = 1", "no such object"},
        Case{"605A = 1", "index:sub-index"}, Case{"2132:00 = nan", "a number"}, Case{"2003:00 = \"open", "quotes"},
        Case{"607C:00 = 99999999999", "out of range"}, Case{"1600:01 = -1", "without sign"}}) {
    write_content("# written by hand\n605B:00 = 1\n" + c.line + "\n");
    DriveRig rig(parameters_);
    rig.pass(5ms);
    EXPECT_EQ(rig.drive.fault(), Fault::kParameterList) << c.line;
    EXPECT_EQ(rig.drive.parameter_file_error().line, 3U);
    EXPECT_NE(rig.drive.parameter_file_error().what.find(c.what), std::string::npos)
        << c.line << ": " << rig.drive.parameter_file_error().what;
    EXPECT_EQ(rig.read(0x605B), 0U) << "nothing of it is taken";
    // Saving repairs the file.
    rig.set({{0x200B, 1, 1, 1}, {0x2099, 0, 1, 1}});
    rig.pass(5ms);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  }
}

TEST_F(MsdParameterFile, OneThatNeverEndsIsRefused) {
  parameters_.parameter_file = "/dev/zero";
  DriveRig rig(parameters_);
  rig.pass(5ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kParameterList);
  EXPECT_EQ(rig.drive.parameter_file_error().what, "is larger than 4 MiB");
}

TEST_F(MsdParameterFile, WhereNothingCanBeWrittenTheUserIsTold) {
  parameters_.parameter_file = (std::filesystem::path(testing::TempDir()) / "no_such_folder" / "file").string();
  DriveRig rig(parameters_);
  EXPECT_FALSE(rig.drive.fault().has_value()) << "no file yet is no error";
  constexpr std::uint32_t kHardwareReason = 0x06060000;
  EXPECT_EQ(rig.write(0x200B, 1, 1, 1), kHardwareReason);
  EXPECT_EQ(rig.read(0x200B, 1), 0U);
  rig.pass(5ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kParameterList);
  EXPECT_EQ(rig.write(0x1010, 1, 0x65766173, 4), kHardwareReason);
  EXPECT_EQ(rig.write(0x1011, 1, 0x64616F6C, 4), kHardwareReason);
  EXPECT_NE(rig.drive.parameter_file_error().what.find("No such file"), std::string::npos);
}

TEST_F(MsdParameterFile, TextWithQuotesAndCommentsSurvives) {
  parameters_.name = "a \"b\" \\ # c";
  {
    DriveRig rig(parameters_);
    ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  }
  parameters_.name = "other";
  DriveRig rig(parameters_);
  EXPECT_EQ(rig.drive.dictionary().text(rig.drive.dictionary().table().find(0x2003, 0)->slot), "a \"b\" \\ # c");
}

}  // namespace
}  // namespace driveline::slaves::msd
