// Inputs set by name.
#include "text/signal_text.hpp"

#include <gmock/gmock.h>

#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::cli {
namespace {

using testing::HasSubstr;

std::string error(std::string_view text) {
  const slaves::msd::MsdDrive drive;
  const auto settings = parse_signal_settings(text, drive.core().signals());
  return settings ? "no error" : settings.error();
}

TEST(SignalText, SettingsComeInOrder) {
  const slaves::msd::MsdDrive drive;
  const auto settings = parse_signal_settings("  ENPO=0   ISD02=1 DC_LINK=48.5 ", drive.core().signals());
  ASSERT_TRUE(settings) << settings.error();
  ASSERT_EQ(settings->size(), 3U);
  EXPECT_EQ(drive.core().signals().signal_name({slaves::SignalId::Direction::kInput, (*settings)[1].input}), "ISD02");
  EXPECT_EQ((*settings)[1].value, 1.0);
  EXPECT_EQ((*settings)[2].value, 48.5);
  EXPECT_TRUE(parse_signal_settings("", drive.core().signals())->empty());
}

TEST(SignalText, WrongSettingsAreOneSentence) {
  EXPECT_EQ(error("ENPO"), "\"ENPO\" is not a setting, INPUT=VALUE is expected");
  EXPECT_THAT(error("enpo=1"), HasSubstr("\"enpo\" is no input of the drive; there are ENPO, ISDSH, ISD00"));
  EXPECT_EQ(error("ENPO=1 ISD00=on"), "ISD00 is \"on\", a number is expected");
  EXPECT_EQ(error("ISD00=nan"), "ISD00 is \"nan\", a number is expected");
  EXPECT_EQ(error("ISD00=2"), "ISD00: 2 does not fit ISD00, 0 or 1 is expected");
  EXPECT_EQ(error("DC_LINK=-1"), "DC_LINK: -1 does not fit DC_LINK, 0 to 1000 V is expected");
  EXPECT_THAT(error("BRAKE=1"), HasSubstr("is no input of the drive"));
}

}  // namespace
}  // namespace driveline::cli
