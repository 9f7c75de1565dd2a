// Object dictionary and SDO of the MSD on a CAN bus (MSD manual 8.1, 8.2).
#include <set>

#include "can_drive_rig.hpp"
#include "driveline/slaves/cia402/words.hpp"
#include "driveline/slaves/msd/msd_table.hpp"

namespace driveline::slaves::msd {
namespace {

struct Request {
  std::chrono::microseconds time;
  const char* request;
  const char* answer;
};

// The 30 frames of MSD manual 8.2.4, with its pauses.
constexpr std::array kTrace{
    Request{18'992'445us, "40 03 20 00 00 00 00 00", "41 03 20 00 64 00 00 00"},
    Request{35'514'341us, "60 00 00 00 00 00 00 00", "00 58 2d 41 78 69 73 00"},
    Request{36'269'620us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{36'982'385us, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
    Request{37'686'447us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{38'421'344us, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
    Request{39'053'526us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{39'749'081us, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
    Request{40'428'981us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{41'085'839us, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
    Request{41'740'755us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{42'514'034us, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
    Request{43'172'512us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{43'908'571us, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
    Request{44'668'466us, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
    Request{53'884'044us, "60 00 00 00 00 00 00 00", "0b 00 00 00 00 00 00 00"},
};

class MsdCanTrace : public EachCanDrive {};

TEST_P(MsdCanTrace, UploadOfTheAliasNameIsThatOfTheManual) {
  CanDriveRig rig(parameters(), {DipSwitch{1}, {}, 500us}, 1);
  const auto begin = kTrace.front().time - 100ms;
  for (const Request& step : kTrace) rig.master.send_at(step.time - begin, Frame::of(0x601, hex(step.request)));
  rig.bus.advance(kTrace.back().time - begin + 5ms);
  const auto answers = rig.seen(0x581);
  ASSERT_EQ(answers.size(), kTrace.size());
  for (std::size_t i = 0; i < kTrace.size(); ++i) {
    EXPECT_EQ(bytes_test::copy_of(answers[i].frame.payload()), hex(kTrace[i].answer)) << i;
    const auto took = answers[i].time - (kTrace[i].time - begin);
    EXPECT_GT(took, 250us) << "shortest time in the trace";
    EXPECT_LT(took, 1ms);
  }
}

// The SDO server is on 600h and 580h plus node-ID.
TEST_P(MsdCan, SdoAnswersOnItsOwnIdentifiersInBothStates) {
  EXPECT_EQ(rig.ask("40 00 10 00 00 00 00 00"), hex("43 00 10 00 92 01 02 00"));
  rig.send(0x60B, "40 00 10 00 00 00 00 00");
  EXPECT_THAT(rig.seen(0x58B), IsEmpty());
  rig.start();
  EXPECT_EQ(rig.ask("40 DB 27 00 00 00 00 00"), hex("43 DB 27 00 92 01 02 00")) << "P 2011 is 1000h";
  rig.nmt(NmtCommand::kStop);
  EXPECT_THAT(rig.ask("40 00 10 00 00 00 00 00"), IsEmpty());
}

/// Reads a text by segments.
std::string text_of(CanDriveRig& rig, std::uint16_t index) {
  const auto first = rig.ask(canopen::SdoMessage{0x40, index, 0, {}}.encode());
  EXPECT_EQ(first[0], std::byte{0x41}) << "more than four bytes";
  std::string out;
  for (bool toggle = false;; toggle = !toggle) {
    const auto answer = rig.ask(toggle ? "70 00 00 00 00 00 00 00" : "60 00 00 00 00 00 00 00");
    const auto segment = canopen::SdoSegment::decode(answer[0]);
    EXPECT_EQ(segment.toggle, toggle);
    for (std::size_t i = 1; i < 8U - segment.unused; ++i) out.push_back(static_cast<char>(answer[i]));
    if (segment.last || out.size() > 100) return out;
  }
}

// Name, hardware and software version are texts of more than four bytes (MSD manual Table 8.1).
TEST_P(MsdCan, TextsAreReadBySegments) {
  const VariantFacts& expected = facts(GetParam());
  EXPECT_EQ(text_of(rig, 0x1008), expected.device_name);
  EXPECT_GT(text_of(rig, 0x1009).size(), 4U);
  EXPECT_EQ(text_of(rig, 0x100A), expected.firmware.text());
}

// The logic check of the data set, and a download without it (MSD manual 8.2.5).
TEST_P(MsdCan, DownloadWithoutLogicCheckTakesAnyOrder) {
  EXPECT_EQ(rig.write(0x607D, 1, 5000, 4), 0x0604'0043U) << "minimum above the maximum of 0";
  ASSERT_EQ(rig.write(0x200B, 4, 1, 1), 0U);
  EXPECT_EQ(rig.write(0x607D, 1, 5000, 4), 0U);
  EXPECT_EQ(rig.write(0x605A, 0, 9, 2), 0x0609'0031U) << "ranges are checked all the same";
  ASSERT_EQ(rig.write(0x607D, 2, 4000, 4), 0U);
  ASSERT_EQ(rig.write(0x200B, 4, 0, 1), 0U);
  rig.run(5ms);
  EXPECT_EQ(rig.drive.core().fault(), Fault::kParameterList) << "the set is not consistent";
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("20 63 21 02 05 00 00 00")));
  EXPECT_EQ(rig.write(0x607D, 2, 4500, 4), 0x0604'0043U) << "the check is on again";
  ASSERT_EQ(rig.write(0x607D, 1, 3000, 4), 0U);
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(rig.drive.core().fault(), std::nullopt);
}

TEST_P(MsdCan, DownloadWithoutLogicCheckNeedsThePowerOff) {
  ASSERT_EQ(rig.write(0x6060, 0, 3, 1), 0U);
  rig.operate();
  rig.enable();
  EXPECT_EQ(rig.write(0x200B, 4, 1, 1), 0x0800'0022U);
  rig.control(0);
  rig.run(50ms);
  EXPECT_EQ(rig.write(0x200B, 4, 1, 1), 0U);
}

// Control by the bus: P 159 = 5 and bit 9 of the status word (MSD manual 11.2).
TEST_P(MsdCan, IsRemoteWithControlLocationCia402Only) {
  rig.operate();
  rig.control(kShutDown);
  EXPECT_TRUE(rig.status() & status_word::kRemote);
  ASSERT_EQ(rig.write(0x209F, 0, 1, 2), 0U) << "terminals";
  rig.run(5ms);
  EXPECT_FALSE(rig.status() & status_word::kRemote);
  rig.enable();
  EXPECT_FALSE(rig.drive.core().power_on());
}

TEST_P(MsdCan, ShortIntegersAreFilledWithTheirSign) {
  ASSERT_EQ(rig.write(0x605B, 0, 0xFFFF, 2), 0U);
  EXPECT_EQ(rig.ask("40 5B 60 00 00 00 00 00"), hex("4B 5B 60 00 FF FF FF FF"));
}

TEST_P(MsdCan, CommunicationObjectsHaveTheDefaultsOfTheManual) {
  struct Expected {
    std::uint16_t index;
    std::uint8_t subindex;
    std::uint32_t value;
  };
  for (const auto& e :
       {Expected{0x1005, 0, 0x80}, Expected{0x1006, 0, 1000}, Expected{0x1007, 0, 0}, Expected{0x100C, 0, 0},
        Expected{0x100D, 0, 0}, Expected{0x1014, 0, 0x8C}, Expected{0x1017, 0, 0}, Expected{0x27D5, 0, 0},
        Expected{0x27D6, 0, 1000}, Expected{0x27DF, 0, 1000}, Expected{0x280D, 0, 0}, Expected{0x280E, 0, 0}}) {
    EXPECT_EQ(rig.read(e.index, e.subindex), e.value) << std::hex << e.index << ':' << int{e.subindex};
  }
  for (std::uint16_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1400 + i), 1), 0x20CU + 0x100U * i);
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1800 + i), 1), 0x18CU + 0x100U * i);
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1400 + i), 2), 255U);
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1800 + i), 2), 255U);
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1600 + i), 0), 0U) << "no mapping";
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1A00 + i), 0), 0U) << "no mapping";
  }
  for (std::uint8_t i = 0; i < 8; ++i) EXPECT_EQ(rig.read(0x27D7, i), 0xFFFF'FFFFU);
  EXPECT_EQ(rig.read(0x1015, 0), 0x0602'0000U) << "not in the list of the manual";
}

// One producer is monitored by the MSD, none by the ServoOne.
TEST_P(MsdCan, HasTheHeartbeatConsumerOfItsManual) {
  const bool consumes = GetParam() == Variant::kMsd;
  EXPECT_EQ(rig.read(0x1016, 0), consumes ? 1U : 0x0602'0000U);
  EXPECT_EQ(rig.read(0x1016, 1), consumes ? 0U : 0x0602'0000U);
  EXPECT_EQ(rig.read(0x1016, 2), consumes ? 0x0609'0011U : 0x0602'0000U);
}

// 1005h and others can be written, 1000h and others cannot (MSD manual Table 8.1).
TEST_P(MsdCan, ObjectsAreReadOnlyOrWritableAsListed) {
  constexpr std::uint32_t kReadOnly = 0x0601'0002;
  for (const auto& [index, size] : {std::pair{0x1000, 4U}, {0x1001, 1U}, {0x280A, 1U}, {0x280B, 2U}, {0x280C, 1U}}) {
    EXPECT_EQ(rig.write(static_cast<std::uint16_t>(index), 0, 1, size), kReadOnly) << std::hex << index;
  }
  EXPECT_EQ(rig.write(0x1005, 0, 0x81, 4), 0U);
  EXPECT_EQ(rig.write(0x1006, 0, 2000, 4), 0U);
  EXPECT_EQ(rig.read(0x27DF), 2000U) << "P 2015 is 1006h";
  EXPECT_EQ(rig.write(0x27DF, 0, 3000, 4), 0U);
  EXPECT_EQ(rig.read(0x1006), 3000U);
  EXPECT_EQ(rig.write(0x1007, 0, 500, 4), 0U);
  EXPECT_EQ(rig.write(0x100C, 0, 100, 2), 0U);
  EXPECT_EQ(rig.write(0x100D, 0, 3, 1), 0U);
  EXPECT_EQ(rig.write(0x1014, 0, 0x8000'008CU, 4), 0U);
  EXPECT_EQ(rig.write(0x1017, 0, 50, 2), 0U);
  EXPECT_EQ(rig.write(0x1402, 2, 1, 1), 0U);
  EXPECT_EQ(rig.write(0x1803, 5, 40, 2), 0U);
  EXPECT_EQ(rig.write(0x1601, 1, 0x607A'0020, 4), 0U);
  EXPECT_EQ(rig.write(0x1A01, 1, 0x6064'0020, 4), 0U);
}

TEST_P(MsdCan, TheHistoryTakesZeroAndNothingElse) {
  EXPECT_EQ(rig.write(0x1003, 0, 1, 1), 0x0609'0030U);
  rig.drive.core().raise(Fault::kEncoder);
  rig.run(2ms);
  EXPECT_EQ(rig.read(0x1003, 0), 1U);
  EXPECT_EQ(rig.read(0x1003, 1), 0x010A'7300U);
  EXPECT_EQ(rig.read(0x1003, 2), 0x0609'0011U) << "one entry";
  EXPECT_EQ(rig.write(0x1003, 0, 0, 1), 0U);
  EXPECT_EQ(rig.read(0x1003, 0), 0U);
  EXPECT_EQ(rig.read(0x1003, 1), 0U);
}

// The dictionaries of both buses have the same rows but for those of the bus.
TEST(MsdCanTable, DiffersFromEtherCatInTheObjectsOfTheBus) {
  const auto addresses = [](const DictionaryTable& table) {
    std::set<std::pair<unsigned, unsigned>> out;
    for (const EntryRow& row : table.rows()) out.emplace(row.index, row.subindex);
    return out;
  };
  for (const Variant variant : {Variant::kMsd, Variant::kServoOne, Variant::kServoOneJunior}) {
    const auto can = addresses(can_dictionary_table(variant));
    const auto ethercat = addresses(dictionary_table(variant));
    std::set<unsigned> only_can;
    std::set<unsigned> only_ethercat;
    for (const auto& [index, sub] : can) {
      if (ethercat.count({index, sub}) == 0) only_can.insert(index);
    }
    for (const auto& [index, sub] : ethercat) {
      if (can.count({index, sub}) == 0) only_ethercat.insert(index);
    }
    EXPECT_THAT(only_ethercat, ElementsAre(0x10F1, 0x1C00, 0x1C12, 0x1C13, 0x1C32, 0x1C33));
    std::set<unsigned> expected{0x1005, 0x1006, 0x1007, 0x100C, 0x100D, 0x1014, 0x1017, 0x27D5,
                                0x27D6, 0x27D7, 0x27DF, 0x280A, 0x280B, 0x280D, 0x280E};
    for (unsigned i = 0; i < 4; ++i) expected.insert({0x1400 + i, 0x1800 + i});
    if (variant == Variant::kMsd) expected.insert(0x1016);
    EXPECT_EQ(only_can, expected);
  }
}

// Modes 8, 9 and 10 exist on EtherCAT only (MSD manual 12.1).
TEST_P(MsdCan, CyclicSynchronousModesAreRefused) {
  for (const std::uint32_t mode : {8U, 9U, 10U}) EXPECT_EQ(rig.write(0x6060, 0, mode, 1), 0x0609'0030U) << mode;
  for (const std::uint32_t mode : {1U, 2U, 3U, 6U, 7U}) {
    EXPECT_EQ(rig.write(0x6060, 0, mode, 1), 0U);
    rig.run(2ms);
    EXPECT_EQ(rig.value(0x6061), mode);
  }
  EXPECT_EQ(rig.read(0x6502), 0x67U);
}

TEST_P(MsdCan, CyclicSynchronousModesInAnRxPdoChangeNothing) {
  rig.map(0x1401, {0x6060'0008});
  rig.start();
  for (const char* mode : {"03", "08", "09", "0A"}) {
    rig.send(0x30C, mode, 3ms);
    EXPECT_EQ(rig.value(0x6061), 3U) << mode;
    EXPECT_EQ(rig.value(0x6060), 3U) << mode;
  }
  rig.send(0x30C, "07", 3ms);
  EXPECT_EQ(rig.value(0x6061), 7U);
}

TEST_P(MsdCan, BitRatesAreThoseOfTheManual) {
  for (const std::uint32_t rate : {20U, 50U, 125U, 250U, 500U, 1000U}) EXPECT_EQ(rig.write(0x27D6, 0, rate, 2), 0U);
  for (const std::uint32_t rate : {100U, 800U, 21U}) EXPECT_EQ(rig.write(0x27D6, 0, rate, 2), 0x0609'0030U) << rate;
  EXPECT_EQ(rig.write(0x27D6, 0, 10, 2), 0x0609'0032U);
}

INSTANTIATE_TEST_SUITE_P(Drives, MsdCanTrace, kEachDrive, drive_name);

}  // namespace
}  // namespace driveline::slaves::msd
