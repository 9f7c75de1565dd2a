// Objects of the drive: identity, strings, parameters with checks or commands, storage.
#include <random>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

std::string upload_text(DriveRig& rig, std::uint16_t index) {
  const auto answer = rig.sdo({0x40, index & 0xFFU, unsigned{index} >> 8, 0, 0, 0, 0, 0});
  EXPECT_EQ(answer.at(0), 0x41U);
  std::string text;
  for (std::size_t i = 8; i < answer.size(); ++i) text += static_cast<char>(answer[i]);
  return text;
}

TEST(MsdObject, Identity) {
  MsdParameters parameters;
  parameters.serial_number = 4711;
  DriveRig rig(parameters);
  EXPECT_EQ(rig.read(0x1000), 0x00020192U);
  EXPECT_EQ(rig.read(0x27DB), 0x00020192U) << "P 2011 is the same value";
  EXPECT_EQ(rig.read(0x1018), 4U);
  EXPECT_EQ(rig.read(0x1018, 1), 0x28U);
  EXPECT_EQ(rig.read(0x1018, 2), kProductCode);
  EXPECT_EQ(rig.read(0x1018, 3), kRevision);
  EXPECT_EQ(rig.read(0x1018, 4), 4711U);
  EXPECT_EQ(upload_text(rig, 0x1008), "MSD Servo Drive");
  EXPECT_EQ(upload_text(rig, 0x1009), "simulation");
  EXPECT_EQ(upload_text(rig, 0x100A), "124.30-00");
  EXPECT_EQ(rig.read(0x6502), 0x3E7U);
}

TEST(MsdObject, AliasNameHas100BytesPaddedWithZeros) {
  MsdParameters parameters;
  parameters.name = "Z";
  DriveRig rig(parameters);
  EXPECT_EQ(upload_text(rig, 0x2003), "Z" + std::string(99, '\0'));
  MsdParameters longer;
  longer.name = std::string(150, 'n');
  DriveRig cut(longer);
  EXPECT_EQ(upload_text(cut, 0x2003), std::string(100, 'n'));
}

TEST(MsdObject, ModeAcceptsOnlyWhatItRuns) {
  DriveRig rig;
  for (int mode = -128; mode < 128; ++mode) {
    const bool runs = mode >= 0 && mode <= 10 && mode != 4 && mode != 5;
    EXPECT_EQ(rig.write(0x6060, 0, static_cast<std::uint8_t>(mode), 1), runs ? 0U : 0x06090030U) << mode;
  }
}

TEST(MsdObject, OptionCodesHaveTheRangesOfTheManual) {
  DriveRig rig;
  struct Range {
    std::uint16_t index;
    int low, high;
  };
  for (const auto& r :
       {Range{0x605A, 0, 8}, Range{0x605B, -1, 1}, Range{0x605C, 0, 1}, Range{0x605D, 0, 4}, Range{0x605E, -2, 4}}) {
    for (int value = -5; value < 12; ++value) {
      const std::uint32_t expected = value > r.high ? 0x06090031U : value < r.low ? 0x06090032U : 0U;
      EXPECT_EQ(rig.write(r.index, 0, static_cast<std::uint16_t>(value), 2), expected)
          << std::hex << r.index << ' ' << value;
    }
  }
}

TEST(MsdObject, InterpolationTypeHasTwoAddressesWithDifferentNumbers) {
  DriveRig rig;
  struct Pair {
    std::uint32_t parameter;
    int sub_mode;
  };
  for (const auto& p : {Pair{0, -1}, Pair{1, 0}, Pair{2, -2}, Pair{3, -3}, Pair{4, -4}, Pair{5, -5}}) {
    ASSERT_EQ(rig.write(0x2172, 0, p.parameter, 1), 0U);
    EXPECT_EQ(static_cast<int>(rig.read(0x60C0)), p.sub_mode);
  }
  for (const auto& p : {Pair{0, -1}, Pair{1, 0}, Pair{2, -2}, Pair{3, -3}, Pair{4, -4}, Pair{5, -5}}) {
    ASSERT_EQ(rig.write(0x60C0, 0, static_cast<std::uint16_t>(p.sub_mode), 2), 0U);
    EXPECT_EQ(rig.read(0x2172), p.parameter);
  }
  EXPECT_EQ(rig.write(0x2172, 0, 6, 1), 0x06090031U);
  EXPECT_EQ(rig.write(0x60C0, 0, static_cast<std::uint16_t>(-6), 2), 0x06090032U);
  EXPECT_EQ(rig.write(0x60C0, 0, 1, 2), 0x06090031U);
}

TEST(MsdObject, TimePeriodHasTwoAddresses) {
  DriveRig rig;
  rig.set({{0x28DA, 0, 25, 1}, {0x28DA, 1, 0xFB, 1}});
  EXPECT_EQ(rig.read(0x60C2, 1), 25U);
  EXPECT_EQ(static_cast<int>(rig.read(0x60C2, 2)), -5);
}

TEST(MsdObject, SynchronisationTypes) {
  DriveRig rig;
  for (const unsigned type : {2U, 1U, 0U}) {
    EXPECT_EQ(rig.write(0x1C32, 1, type, 2), 0U);
    EXPECT_EQ(rig.write(0x1C33, 1, 2 - type, 2), 0U);
    EXPECT_EQ(rig.read(0x1C32, 1), type);
    EXPECT_EQ(rig.read(0x1C33, 1), 2 - type);
  }
  EXPECT_EQ(rig.write(0x1C32, 1, 3, 2), 0x06090031U);
  EXPECT_EQ(rig.write(0x1C32, 1, 0x22, 2), 0x06090031U);
  EXPECT_EQ(rig.write(0x1C33, 1, 0x22, 2), 0U) << "the event of the outputs";
  for (const unsigned type : {3U, 0x21U}) EXPECT_EQ(rig.write(0x1C33, 1, type, 2), 0x06090030U);
  EXPECT_EQ(rig.write(0x1C33, 1, 0x23, 2), 0x06090031U);
  EXPECT_EQ(rig.read(0x1C33, 1), 0x22U);
}

TEST(MsdObject, StoreNeedsItsSignature) {
  DriveRig rig;
  EXPECT_EQ(rig.write(0x1010, 1, 1, 4), 0x08000020U);
  EXPECT_EQ(rig.write(0x1011, 1, 0x65766173, 4), 0x08000020U);
  EXPECT_EQ(rig.write(0x1010, 1, 0x65766173, 4), 0U);
  EXPECT_EQ(rig.read(0x1010, 1), 1U);
}

TEST(MsdObject, StoredParametersSurviveARestartTheOthersDoNot) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x605A, 0, 6, 2), 0U);
  rig.map(0x1600, {0x60400010});
  rig.set({{0x6060, 0, 8, 1}, {0x200B, 1, 1, 1}, {0x605B, 0, 1, 2}});
  rig.restart();
  EXPECT_EQ(rig.read(0x605A), 6U);
  EXPECT_EQ(rig.read(0x1600), 1U);
  EXPECT_EQ(rig.device.process_data_size(2), 2U);
  EXPECT_EQ(rig.read(0x605B), 0U) << "written after saving";
  EXPECT_EQ(rig.read(0x6060), 0U) << "not a parameter that is saved";
}

TEST(MsdObject, FactoryResetActsAfterSavingAndRestarting) {
  DriveRig rig;
  rig.set({{0x605A, 0, 6, 2}, {0x200B, 1, 1, 1}, {0x200B, 3, 1, 1}});
  EXPECT_EQ(rig.read(0x605A), 6U);
  rig.restart();
  EXPECT_EQ(rig.read(0x605A), 6U) << "not saved";
  rig.set({{0x200B, 3, 1, 1}, {0x200B, 1, 1, 1}});
  rig.restart();
  EXPECT_EQ(rig.read(0x605A), 2U);
}

TEST(MsdObject, RestoreDefaultsOverThe1011hObject) {
  DriveRig rig;
  rig.set({{0x605A, 0, 6, 2}, {0x1010, 1, 0x65766173, 4}, {0x1011, 1, 0x64616F6C, 4}});
  rig.restart();
  EXPECT_EQ(rig.read(0x605A), 2U);
  EXPECT_EQ(upload_text(rig, 0x2003).substr(0, 6), "X-Axis") << "facts of the drive stay";
}

TEST(MsdObject, RestartSwitchesOff) {
  OperatingRig rig;
  rig.run_at(5'000'000);
  rig.restart();
  EXPECT_EQ(rig.drive.state(), PowerState::kNotReadyToSwitchOn);
  rig.pass(500ms);
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
}

TEST(MsdObject, SdoWorksInEveryMailboxState) {
  DriveRig rig;
  EXPECT_EQ(rig.read(0x6061), 0U);
  rig.operate();
  EXPECT_EQ(rig.read(0x6061), 0U);
  rig.to(AlState::kOp, AlState::kSafeOp);
  EXPECT_EQ(rig.read(0x6061), 0U);
}

TEST(MsdObject, EveryRowHasASourceANameAndADefaultInItsRange) {
  for (const auto& row : dictionary_table().rows()) {
    SCOPED_TRACE(testing::Message() << std::hex << row.index << ':' << int{row.subindex});
    EXPECT_FALSE(row.source.empty());
    EXPECT_FALSE(row.name.empty());
    if (row.minimum > row.initial || row.maximum < row.initial) {
      // set by the drive at start: gains and inertia have no default of the type
      ADD_FAILURE();
    }
    EXPECT_NE(row.access & access::kReadWrite, 0);
    EXPECT_TRUE((row.access & access::kRxMappable) == 0 || (row.access & access::kWriteOperating) != 0);
  }
}

TEST(MsdObject, EveryObjectCanBeUploadedAndSurvivesRandomDownloads) {
  std::mt19937 random(5);
  EnabledRig rig(8);
  for (int round = 0; round < 60; ++round) {
    for (const auto& row : dictionary_table().rows()) {
      const std::uint32_t value =
          round % 3 == 0 ? static_cast<std::uint32_t>(random()) : static_cast<std::uint32_t>(random() % 16);
      const auto size = static_cast<unsigned>(byte_size(row.type));
      if (size != 0) rig.write(row.index, row.subindex, value, size);
      const auto answer = rig.sdo({0x40, row.index & 0xFFU, unsigned{row.index} >> 8, row.subindex, 0, 0, 0, 0});
      ASSERT_FALSE(answer.empty());
    }
    rig.pass(2ms);
    ASSERT_TRUE(std::isfinite(rig.drive.position_rad()));
    ASSERT_TRUE(std::isfinite(rig.drive.torque_nm()));
    ASSERT_LE(std::abs(rig.drive.torque_nm()), 7.3);
  }
}

TEST(MsdObject, RandomProcessDataNeverBreaksThePlant) {
  std::mt19937 random(11);
  EnabledRig rig(8);
  std::vector<std::byte> data(20);
  for (int i = 0; i < 20000; ++i) {
    for (auto& b : data) b = static_cast<std::byte>(random());
    if (i % 50 != 0) {  // mostly enabled, in a moving mode
      data[0] = std::byte{0x0F};
      data[1] = std::byte{0};
      data[2] = static_cast<std::byte>(8 + i / 1000 % 3);
    }
    rig.device.write_outputs(2, std::span(data).first(random() % 21));
    rig.pass(125us);
    ASSERT_TRUE(std::isfinite(rig.drive.position_rad()));
    ASSERT_LE(std::abs(rig.drive.velocity_rad_s()), 720.0) << "beyond what the voltage allows";
  }
}

TEST(MsdObject, OneDriveStaysSmall) {
  // values, strings and request queue on the heap, the object itself, far from 64 KiB
  const std::size_t values = 2 * dictionary_table().slot_count() * sizeof(std::uint64_t);
  const std::size_t mailbox = MailboxServer::kQueueDepth * 512 + 512;
  const std::size_t list = 2 * (dictionary_table().rows().size() + 1);
  DriveRig rig;
  EXPECT_LT(sizeof(MsdDrive) + values + mailbox + list + rig.device.profile().sii_image.size() + 2048, 17U * 1024U);
}

}  // namespace
}  // namespace driveline::slaves::msd
