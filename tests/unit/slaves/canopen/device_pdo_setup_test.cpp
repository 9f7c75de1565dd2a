#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

constexpr std::uint32_t kValueRange = 0x0609'0030;

// C35: identifiers of the predefined connection set, from the node-ID.
TEST_F(CanopenDevice, C35PredefinedConnectionSet) {
  const std::array<std::uint32_t, 8> expected{0x205, 0x305, 0x405, 0x505, 0x185, 0x285, 0x385, 0x485};
  for (std::uint16_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1400 + i), 1), expected.at(i));
    EXPECT_EQ(rig.read(static_cast<std::uint16_t>(0x1800 + i), 1), expected.at(i + 4U));
  }
}

// C35: identifier bits change only while bit 31 is or becomes 1 (CANopenNode #323: OD 02, OD 08).
TEST_F(CanopenDevice, C35IdentifierIsLockedWhileThePdoExists) {
  for (const std::uint16_t index : {std::uint16_t{0x1401}, std::uint16_t{0x1801}}) {
    const std::uint32_t now = rig.read(index, 1);
    EXPECT_EQ(rig.write(index, 1, now + 0x11, 4), kValueRange);
    EXPECT_EQ(rig.write(index, 1, now | 0x2000'0000U, 4), kValueRange);
    EXPECT_EQ(rig.write(index, 1, now | 0x4000'0000U, 4), 0U);  // bit 30 is no bit of the identifier
    EXPECT_EQ(rig.write(index, 1, (now + 0x11) | 0x8000'0000U, 4), 0U);
    EXPECT_EQ(rig.write(index, 1, (now + 0x22) | 0x8000'0000U, 4), 0U);
    EXPECT_EQ(rig.write(index, 1, now + 0x33, 4), 0U);  // exists from here on
    EXPECT_EQ(rig.write(index, 1, now + 0x34, 4), kValueRange);
  }
}

TEST_F(CanopenDevice, C35RestrictedAndMalformedIdentifiers) {
  ASSERT_EQ(rig.write(0x1800, 1, 0x8000'0185, 4), 0U);
  for (const std::uint32_t value :
       {0x000U, 0x07FU, 0x101U, 0x180U, 0x581U, 0x605U, 0x6E0U, 0x705U, 0x7FFU, 0x800U, 0x1'0185U}) {
    EXPECT_EQ(rig.write(0x1800, 1, value, 4), kValueRange) << std::hex << value;
  }
  EXPECT_EQ(rig.write(0x1800, 1, 0x2000'0705, 4), 0U);  // with 29 bits it is another one
}

// C36: sub 0 = 0 first, entries, then the count.
TEST_F(CanopenDevice, C36MappingOrder) {
  ASSERT_EQ(rig.write(0x1A00, 1, 0x2000'0010, 4), 0U);
  ASSERT_EQ(rig.write(0x1A00, 0, 1, 1), 0U);
  EXPECT_NE(rig.write(0x1A00, 1, 0x2001'0008, 4), 0U);  // while the count is not 0
  ASSERT_EQ(rig.write(0x1A00, 0, 0, 1), 0U);
  EXPECT_EQ(rig.write(0x1A00, 1, 0x2001'0008, 4), 0U);
}

// C36: checks of entries: existence, sub-index, mappability, length, direction, sum of bits; mapping to itself.
TEST_F(CanopenDevice, C36MappingEntries) {
  struct Row {
    std::uint16_t index;
    std::uint32_t entry;
    std::uint32_t abort;
  };
  for (const auto& row : {Row{0x1601, 0x5FFF'0010, 0x0602'0000}, Row{0x1601, 0x2000'0110, 0x0609'0011},
                          Row{0x1601, 0x2003'0020, 0x0604'0041}, Row{0x1601, 0x2000'0011, 0x0604'0041},
                          Row{0x1601, 0x1001'0008, 0x0604'0041}, Row{0x1A01, 0x1001'0008, 0},
                          Row{0x1601, 0x1601'0120, 0x0604'0041}, Row{0x1601, 0x2000'0010, 0}}) {
    EXPECT_EQ(rig.write(row.index, 1, row.entry, 4), row.abort) << std::hex << row.entry;
  }
  for (std::uint8_t sub = 1; sub <= 8; ++sub)
    ASSERT_EQ(rig.write(0x1602, sub, 0x2001'0008, 4), 0U);  // eight times the same
  EXPECT_EQ(rig.write(0x1602, 0, 8, 1), 0U);
  ASSERT_EQ(rig.write(0x1602, 0, 0, 1), 0U);
  ASSERT_EQ(rig.write(0x1602, 8, 0x2000'0010, 4), 0U);
  EXPECT_EQ(rig.write(0x1602, 0, 8, 1), 0x0604'0042U);  // 72 bits
  EXPECT_EQ(rig.write(0x1602, 0, 9, 1), 0x0604'0042U);
  EXPECT_EQ(rig.write(0x1602, 0, 7, 1), 0U);
}

// The MC7000 takes entries while the mapping is in use (MC7000 manual 6.5.2.1).
TEST(CanopenOpenMapping, TakesEntriesWithoutSwitchingThePdoOff) {
  DeviceRig rig({.mapping = {.locked = false}});
  rig.run(2ms);
  ASSERT_EQ(rig.write(0x1601, 1, 0x2000'0010, 4), 0U);
  ASSERT_EQ(rig.write(0x1601, 0, 1, 1), 0U);
  rig.start();
  EXPECT_EQ(rig.write(0x1601, 1, 0x2001'0008, 4), 0U);
  rig.send(0x305, "4D");
  EXPECT_EQ(rig.value(0x2001), 0x4DU);
  EXPECT_EQ(rig.write(0x1601, 1, 0x2000'0011, 4), 0x0604'0041U);
  for (std::uint8_t sub = 2; sub <= 7; ++sub) ASSERT_EQ(rig.write(0x1601, sub, 0x2001'0008, 4), 0U);
  ASSERT_EQ(rig.write(0x1601, 8, 0x2000'0010, 4), 0U);
  EXPECT_EQ(rig.write(0x1601, 0, 8, 1), 0x0604'0042U) << "72 bits";
  ASSERT_EQ(rig.write(0x1601, 0, 7, 1), 0U);
  EXPECT_EQ(rig.write(0x1601, 7, 0x2000'0010, 4), 0U) << "64 bits";
  EXPECT_EQ(rig.write(0x1601, 6, 0x2000'0010, 4), 0x0604'0042U) << "an entry of a mapping in use is counted, too";
}

// C37 (canopen-stack #138): dummy entries take their bits and nothing else; any number of them, within bounds.
TEST_F(CanopenDevice, C37DummyEntries) {
  rig.map(0x1400, {0x0005'0008, 0x2000'0010, 0x0006'0010, 0x2001'0008, 0x0003'0010});
  rig.start();
  rig.send(0x205, "EE 34 12 EE EE 77 EE EE");
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_EQ(rig.value(0x2001), 0x77U);
  rig.nmt(canopen::NmtCommand::kEnterPreOperational);
  rig.map(0x1401,
          {0x0001'0001, 0x0002'0008, 0x0004'0020, 0x0005'0008, 0x0001'0001, 0x0001'0001, 0x0005'0008, 0x0001'0001});
  rig.start();
  rig.send(0x305, "FF FF FF FF FF FF FF FF");
  EXPECT_EQ(rig.value(0x2001), 0x77U);
  rig.nmt(canopen::NmtCommand::kEnterPreOperational);
  struct Row {
    std::uint16_t index;
    std::uint32_t entry;
  };
  for (const auto& row : {Row{0x1602, 0x0005'0010}, Row{0x1602, 0x0005'0108}, Row{0x1602, 0x0008'0020},
                          Row{0x1602, 0x0000'0008}, Row{0x1A02, 0x0005'0008}}) {
    EXPECT_NE(rig.write(row.index, 1, row.entry, 4), 0U) << std::hex << row.entry;  // wrong length, no type, a TPDO
  }
}

// C39, C40: transmission types (CANopenNode #323: PDO 07, PDO 22).
TEST_F(CanopenDevice, C40TransmissionTypes) {
  for (std::uint32_t type = 0; type <= 255; ++type) {
    const bool synchronous = type <= 240;
    EXPECT_EQ(rig.write(0x1400, 2, type, 1), synchronous || type >= 254 ? 0U : kValueRange) << type;
    EXPECT_EQ(rig.write(0x1800, 2, type, 1), synchronous || type >= 254 ? 0U : kValueRange) << type;
  }
}

TEST(CanopenRemoteTypes, C40AreAcceptedWhereTheyAreAnswered) {  // CANopenNode #99: accepted and never answered
  DeviceRig rig({.remote_types = true});
  rig.run(2ms);
  EXPECT_EQ(rig.write(0x1800, 2, 251, 1), kValueRange);
  EXPECT_EQ(rig.write(0x1400, 2, 252, 1), kValueRange);  // no types of an RPDO
  rig.map(0x1800, {0x2001'0008}, 252);
  rig.map(0x1801, {0x2001'0008}, 253);
  rig.start();
  rig.set(0x2001, 11);
  rig.device.watch(rig.bus.now());
  rig.sync();
  rig.set(0x2001, 22);
  EXPECT_THAT(rig.seen(0x185), IsEmpty());
  EXPECT_THAT(rig.seen(0x285), IsEmpty());
  rig.send(Frame::remote({0x185, false}, 1));
  rig.send(Frame::remote({0x285, false}, 1));
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("0B")));  // sampled at the SYNC
  EXPECT_THAT(rig.payloads(0x285), ElementsAre(hex("16")));
}

}  // namespace
}  // namespace driveline::slaves::cia301
