// Differences of the ServoOne and the ServoOne junior from the MSD: those of docs/servoone.md.
#include <algorithm>
#include <map>
#include <set>

#include "drive_rig.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::slaves::msd {
namespace {

MsdParameters make(Variant variant, std::optional<FirmwareVersion> firmware = std::nullopt) {
  MsdParameters parameters;
  parameters.variant = variant;
  parameters.firmware = firmware;
  return parameters;
}

std::string upload_short_text(DriveRig& rig, std::uint16_t index) {
  const auto answer = rig.sdo({0x40, index & 0xFFU, unsigned{index} >> 8, 0, 0, 0, 0, 0});
  std::string text;
  const bool expedited = (answer.at(0) & 0x02) != 0;
  for (std::size_t i = expedited ? 4 : 8; i < answer.size(); ++i) text += static_cast<char>(answer[i]);
  return text;
}

TEST(ServoOne, EveryVariantHasAnIdentityOfItsOwn) {
  std::set<std::uint32_t> products;
  for (const auto& facts : kVariants) {
    SCOPED_TRACE(facts.key);
    DriveRig rig(make(facts.variant));
    EXPECT_EQ(rig.drive.variant(), facts.variant);
    EXPECT_EQ(rig.read(0x1018, 1), 0x28U);
    EXPECT_EQ(rig.read(0x1018, 2), facts.product_code);
    EXPECT_EQ(rig.read(0x1018, 3), facts.revision);
    EXPECT_EQ(upload_short_text(rig, 0x1008), facts.device_name);
    EXPECT_EQ(upload_short_text(rig, 0x100A), facts.firmware.text());
    const auto image = esi::decode_sii(rig.device.profile().sii_image);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->product_code, facts.product_code);
    EXPECT_EQ(image->revision, facts.revision);
    products.insert(facts.product_code);
    EXPECT_EQ(find_variant(facts.key), facts.variant);
  }
  EXPECT_EQ(products.size(), kVariants.size());
  EXPECT_EQ(find_variant("servotwo"), std::nullopt);
}

TEST(ServoOne, DictionariesDifferInWhatTheManualsDifferAndInNothingElse) {
  using Address = std::pair<std::uint16_t, std::uint8_t>;
  const auto by_address = [](Variant variant) {
    std::map<Address, EntryRow> rows;
    for (const auto& row : dictionary_table(variant).rows()) rows.emplace(Address{row.index, row.subindex}, row);
    return rows;
  };
  const auto msd = by_address(Variant::kMsd);
  for (const auto variant : {Variant::kServoOne, Variant::kServoOneJunior}) {
    const auto other = by_address(variant);
    std::set<std::uint16_t> missing;
    std::set<std::uint16_t> different;
    for (const auto& [address, row] : msd) {
      const auto found = other.find(address);
      if (found == other.end()) {
        missing.insert(address.first);
        continue;
      }
      const auto& its = found->second;
      EXPECT_EQ(its.type, row.type);
      EXPECT_EQ(its.access, row.access);
      EXPECT_EQ(its.power_off_only, row.power_off_only);
      const bool same = its.name == row.name && its.text == row.text && its.initial - row.initial == 0.0 &&
                        its.minimum >= row.minimum && its.maximum <= row.maximum;
      if (!same) different.insert(address.first);
    }
    EXPECT_EQ(missing, std::set<std::uint16_t>{0x607F});
    EXPECT_EQ(different, (std::set<std::uint16_t>{0x1008, 0x100A, 0x1018, 0x605D}));
    EXPECT_EQ(other.size() + 1, msd.size()) << "nothing is there that the MSD lacks";
  }
}

TEST(ServoOne, HasNoMaxProfileVelocity) {
  DriveRig rig(make(Variant::kServoOne));
  EXPECT_EQ(rig.write(0x607F, 0, 1000, 4), 0x06020000U);
  EXPECT_EQ(rig.write(0x1600, 1, 0x607F0020, 4), 0x06020000U);
  rig.start(3);
  rig.turn(20 * 1048576, 4000);
  EXPECT_NEAR(rig.velocity, 20 * 1048576, 3000) << "the profile has no limit but that of the motor";
  EXPECT_EQ(rig.status & 0x0800, 0);
}

/// The name in the drive's answer to Get Object Description Request (ETG.1000.6 5.6.3.4).
std::string name_by_sdo_information(DriveRig& rig, std::uint16_t index) {
  const unsigned low = index & 0xFFU;
  const unsigned high = unsigned{index} >> 8;
  const auto answer = rig.coe(8, {3, 0, 0, 0, low, high});
  // Op code of the response, no fragment to follow; index, data type, number of entries, object code; name.
  const std::vector<unsigned> head = {4, 0, 0, 0, low, high};
  constexpr std::size_t kNameAt = 10;
  if (answer.size() < kNameAt || !std::equal(head.begin(), head.end(), answer.begin())) return "no description";
  std::string name;
  for (std::size_t i = kNameAt; i < answer.size(); ++i) name += static_cast<char>(answer[i]);
  return name;
}

TEST(ServoOne, HaltIsCalledStop) {
  const auto name = [](Variant variant) {
    DriveRig rig(make(variant));
    return name_by_sdo_information(rig, 0x605D);
  };
  EXPECT_EQ(name(Variant::kMsd), "Halt option code");
  EXPECT_EQ(name(Variant::kServoOne), "Stop option code");
  EXPECT_EQ(name(Variant::kServoOneJunior), "Stop option code");
  DriveRig rig(make(Variant::kServoOne));
  for (const unsigned code : {0U, 1U, 2U, 3U, 4U}) EXPECT_EQ(rig.write(0x605D, 0, code, 2), 0U) << "the same values";
  EXPECT_EQ(rig.write(0x605D, 0, 5, 2), 0x06090031U);
}

/// Speed in CSV with a target of zero and an offset that has been selected as external feed-forward.
std::int32_t speed_with_offset(Variant variant, std::uint32_t interpolation) {
  DriveRig rig(make(variant));
  EXPECT_EQ(rig.write(0x2172, 0, interpolation, 1), 0U);
  rig.operate();
  EXPECT_EQ(rig.write(0x217B, 1, 1, 2), 0U);
  rig.enable(9);
  rig.velocity_offset = 1'000'000;
  rig.cycles(1600);
  return rig.velocity;
}

TEST(ServoOne, ExternalFeedForwardNeedsTheSplineForIt) {
  for (const auto variant : {Variant::kServoOne, Variant::kServoOneJunior}) {
    for (const unsigned interpolation : {0U, 1U, 3U, 4U, 5U}) {
      EXPECT_NEAR(speed_with_offset(variant, interpolation), 0, 3000) << interpolation;
    }
    EXPECT_NEAR(speed_with_offset(variant, 2), 1'000'000, 3000);
  }
  EXPECT_NEAR(speed_with_offset(Variant::kMsd, 1), 1'000'000, 3000) << "the MSD asks for nothing";
}

TEST(ServoOne, SplineWithExternalFeedForwardStillNeedsItsSelection) {
  DriveRig rig(make(Variant::kServoOne));
  ASSERT_EQ(rig.write(0x2172, 0, 2, 1), 0U);
  rig.start(9);
  rig.velocity_offset = 1'000'000;
  rig.cycles(1600);
  EXPECT_NEAR(rig.velocity, 0, 3000);
}

TEST(ServoOne, PdosHaveAnEvenNumberOfBytesBeforeFirmware41502) {
  constexpr std::uint32_t kIncompatible = 0x06040043;
  const auto write_count = [](DriveRig& rig, const std::vector<std::uint32_t>& entries) {
    EXPECT_EQ(rig.write(0x1600, 0, 0, 1), 0U);
    for (unsigned i = 0; i < entries.size(); ++i) EXPECT_EQ(rig.write(0x1600, i + 1, entries[i], 4), 0U);
    return rig.write(0x1600, 0, static_cast<std::uint32_t>(entries.size()), 1);
  };
  const std::vector<std::uint32_t> odd = {0x60400010, 0x60600008};
  const std::vector<std::uint32_t> filled = {0x60400010, 0x60600008, 0x28070008};
  for (const auto variant : {Variant::kServoOne, Variant::kServoOneJunior}) {
    for (const FirmwareVersion old : {FirmwareVersion{3, 25, 0}, FirmwareVersion{4, 15, 1}}) {
      DriveRig rig(make(variant, old));
      EXPECT_EQ(write_count(rig, odd), kIncompatible);
      EXPECT_EQ(rig.device.process_data_size(2), 0U) << "nothing is mapped";
      EXPECT_EQ(write_count(rig, filled), 0U);
      EXPECT_EQ(rig.device.process_data_size(2), 4U);
      EXPECT_EQ(upload_short_text(rig, 0x100A), old.text());
    }
    DriveRig rig(make(variant, FirmwareVersion{4, 15, 2}));
    EXPECT_EQ(write_count(rig, odd), 0U);
    EXPECT_EQ(rig.device.process_data_size(2), 3U);
  }
  DriveRig msd;
  EXPECT_EQ(write_count(msd, odd), 0U);
}

TEST(ServoOne, StoresAndRestoresLikeTheMsd) {
  DriveRig rig(make(Variant::kServoOne, FirmwareVersion{4, 10, 0}));
  rig.set({{0x605A, 0, 6, 2}, {0x200B, 1, 1, 1}});
  rig.restart();
  EXPECT_EQ(rig.read(0x605A), 6U);
  EXPECT_EQ(upload_short_text(rig, 0x100A), "4.10-00");
  EXPECT_EQ(upload_short_text(rig, 0x1008), "ServoOne");
}

TEST(FirmwareVersionText, IsReadAndWrittenAsTheManualsDo) {
  EXPECT_EQ((FirmwareVersion{4, 15, 2}.text()), "4.15-02");
  EXPECT_EQ((FirmwareVersion{124, 30, 0}.text()), "124.30-00");
  EXPECT_EQ(FirmwareVersion::parse("4.15-02"), (FirmwareVersion{4, 15, 2}));
  EXPECT_EQ(FirmwareVersion::parse("V124.25-11"), (FirmwareVersion{124, 25, 11}));
  for (const auto* wrong : {"", "V", "4", "4.15", "4.15-", "4.15-2", "4.5-02", "4.15.02", "4.15-02 ", "256.00-00",
                            "-4.15-02", "4.15-002"}) {
    EXPECT_EQ(FirmwareVersion::parse(wrong), std::nullopt) << wrong;
  }
}

/// When the LED changes within 12 s, in ms.
std::vector<int> changes(auto&& led) {
  std::vector<int> times;
  bool before = false;
  for (int ms = 0; ms < 2000; ++ms) {
    const bool now = led(std::chrono::milliseconds(ms));
    if (now != before) times.push_back(ms);
    before = now;
  }
  return times;
}

TEST(ServoOneLeds, BottomLedIsRunAtBothSocketsWhereSomebodyIsConnected) {
  const auto at = [](Connector connector, bool link) {
    return bottom_led(Series::kServoOne, connector, {link, false}, AlState::kOp, 0ms);
  };
  EXPECT_TRUE(at(Connector::kX15, true));
  EXPECT_TRUE(at(Connector::kX15, false));
  EXPECT_TRUE(at(Connector::kX16, true));
  EXPECT_FALSE(at(Connector::kX16, false)) << "no further user at the output";
  EXPECT_FALSE(bottom_led(Series::kServoOne, Connector::kX16, {true, true}, AlState::kInit, 0ms));
}

TEST(ServoOneLeds, BottomLedOfTheJuniorIsTheLinkOfThePhy) {
  for (const auto connector : {Connector::kX15, Connector::kX16}) {
    EXPECT_TRUE(bottom_led(Series::kServoOneJunior, connector, {true, true}, AlState::kInit, 0ms));
    EXPECT_FALSE(bottom_led(Series::kServoOneJunior, connector, {false, false}, AlState::kOp, 0ms));
  }
}

TEST(ServoOneLeds, H1IsGreenForTheStateAndRedForTheError) {
  const auto red = [](AlStatusCode code) {
    return changes([code](auto time) {
      return status_led_h1({AlState::kSafeOp, code != AlStatusCode::kNoError}, code, time).red;
    });
  };
  EXPECT_EQ(red(AlStatusCode::kNoError), (std::vector<int>{}));
  EXPECT_EQ(red(AlStatusCode::kInvalidOutputConfiguration),
            (std::vector<int>{0, 200, 400, 600, 800, 1000, 1200, 1400, 1600, 1800}))
      << "flashing";
  EXPECT_EQ(red(AlStatusCode::kFatalSyncError), (std::vector<int>{0, 200, 1200, 1400})) << "single flash";
  EXPECT_EQ(red(AlStatusCode::kSyncManagerWatchdog), (std::vector<int>{0, 200, 400, 600, 1600, 1800}))
      << "double flash";
  const auto green = [](AlState state) {
    return changes([state](auto time) { return status_led_h1({state, false}, AlStatusCode::kNoError, time).green; });
  };
  EXPECT_EQ(green(AlState::kInit), (std::vector<int>{}));
  EXPECT_EQ(green(AlState::kPreOp), (std::vector<int>{0, 200, 400, 600, 800, 1000, 1200, 1400, 1600, 1800}));
  EXPECT_EQ(green(AlState::kSafeOp), (std::vector<int>{0, 200, 1200, 1400}));
  EXPECT_EQ(green(AlState::kOp), (std::vector<int>{0}));
}

TEST(ServoOneLeds, EveryErrorOfTheStandardHasAnIndication) {
  for (const auto& row : wire::kAlStatusCodeTexts) {
    const auto shown = error_indication({AlState::kPreOp, true}, row.code);
    EXPECT_EQ(shown == ErrorIndication::kNone, row.code == AlStatusCode::kNoError) << row.text;
    EXPECT_EQ(shown == ErrorIndication::kWatchdog, row.code == AlStatusCode::kSyncManagerWatchdog) << row.text;
    EXPECT_EQ(error_indication({AlState::kPreOp, false}, row.code), ErrorIndication::kNone) << row.text;
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
