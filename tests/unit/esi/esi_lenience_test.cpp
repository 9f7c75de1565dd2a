// Deviations of real vendor files from the schema, and how the reader handles them.
#include <gmock/gmock.h>

#include "driveline/esi/esi_file.hpp"

namespace driveline::esi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

EsiFile read(std::string_view xml) {
  auto file = read_esi(xml, "vendor.xml");
  EXPECT_TRUE(file) << to_text(file.error());
  return file.value_or(EsiFile{});
}

EsiFile read_device(const std::string& content) {
  return read(
      "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device><Type ProductCode='1' "
      "RevisionNo='1'>X</Type>" +
      content + "</Device></Devices></Descriptions></EtherCATInfo>");
}

/// The text in UTF-16 with a byte order mark.
std::string utf16(std::u16string_view text, bool big_endian) {
  std::string bytes;
  const auto put = [&](char16_t unit) {
    const char high = static_cast<char>(unit >> 8);
    const char low = static_cast<char>(unit & 0xFF);
    bytes += big_endian ? high : low;
    bytes += big_endian ? low : high;
  };
  put(0xFEFF);
  for (const char16_t unit : text) put(unit);
  return bytes;
}

TEST(EsiLenience, Utf16InBothByteOrders) {
  constexpr std::u16string_view kXml =
      u"<?xml version=\"1.0\" encoding=\"utf-16\"?>\n<EtherCATInfo><Vendor><Id>7</Id>"
      u"<Name>\u00C4ntriebe \u4E2D \U0001F600</Name></Vendor></EtherCATInfo>";
  for (const bool big_endian : {false, true}) {
    const EsiFile file = read(utf16(kXml, big_endian));
    EXPECT_EQ(file.vendor_id, 7U);
    EXPECT_EQ(file.vendor_name, "\xC3\x84ntriebe \xE4\xB8\xAD \xF0\x9F\x98\x80");
  }
}

TEST(EsiLenience, BrokenUtf16IsAnErrorWithALine) {
  const auto odd = read_esi(utf16(u"<EtherCATInfo>\n<\xD800", false) + "x", "f.xml");
  ASSERT_FALSE(odd);
  EXPECT_THAT(to_text(odd.error()), HasSubstr("f.xml:2: not well-formed XML"));
  EXPECT_FALSE(read_esi("\xFF\xFE<", "f.xml"));
}

TEST(EsiLenience, AListOfInfos) {
  const EsiFile file = read(
      "<EtherCATInfoList><EtherCATInfo><Vendor><Id>1</Id></Vendor></EtherCATInfo>"
      "<EtherCATInfo><Vendor><Id>2</Id></Vendor></EtherCATInfo></EtherCATInfoList>");
  EXPECT_EQ(file.vendor_id, 1U);
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_EQ(file.notes[0].text, "only the first of a list is read");
}

TEST(EsiLenience, FlagsInAnyCaseAndAsRegisterValues) {
  const auto device = read_device(
                          "<Sm Enable='#x09'>Outputs</Sm><Sm Enable='8'>Inputs</Sm><Sm Enable='TRUE'/>"
                          "<TxPdo Fixed='True' Mandatory='FALSE'><Index>#x1A00</Index></TxPdo>")
                          .devices.at(0);
  EXPECT_TRUE(device.sync_managers[0].enable);
  EXPECT_FALSE(device.sync_managers[1].enable);  // only in OP, bit 3
  EXPECT_TRUE(device.sync_managers[2].enable);
  EXPECT_TRUE(device.tx_pdos[0].fixed);
  EXPECT_FALSE(device.tx_pdos[0].mandatory);
}

TEST(EsiLenience, ProfileOfTheFirstChannel) {
  const auto device = read_device("<Profile><ChannelInfo><ProfileNo>5001</ProfileNo></ChannelInfo></Profile>").devices;
  EXPECT_EQ(device.at(0).device_profile, 5001);
}

TEST(EsiLenience, NumbersWhereHexBinaryBelongs) {
  const auto file = read_device(
      "<Profile><Dictionary><Objects><Object><Index>#x2000</Index><Name>A</Name><Type>UINT</Type><BitSize>16</BitSize>"
      "<Info><DefaultData>#x1234</DefaultData><MinData>0x01</MinData><MaxData>so many</MaxData></Info>"
      "<Flags><Access>RW</Access></Flags></Object></Objects></Dictionary></Profile>");
  const auto& entry = file.devices.at(0).objects.at(0).entries.at(0);
  EXPECT_EQ(entry.default_hex, "3412");
  EXPECT_EQ(entry.minimum_hex, "0100");
  EXPECT_EQ(entry.maximum_hex, "");
  EXPECT_TRUE(entry.writable);
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_EQ(file.notes[0].text, "'so many' is not a whole number; ignored");
}

TEST(EsiLenience, EntriesLongerThanAByteCanCount) {
  const auto file = read_device(
      "<TxPdo><Index>#x1A00</Index><Entry><Index>#x6000</Index><SubIndex>1</SubIndex><BitLen>600</BitLen>"
      "<DataType>ARRAY [0..74] OF "
      "BYTE</DataType></Entry><Entry><Index>#x6001</Index><BitLen>1</BitLen></Entry></TxPdo>");
  const auto& entries = file.devices.at(0).tx_pdos.at(0).entries;
  ASSERT_EQ(entries.size(), 4U);
  EXPECT_EQ(entries[0].bit_length, 255);
  EXPECT_EQ(entries[1].index, 0);
  EXPECT_EQ(255 + entries[1].bit_length + entries[2].bit_length, 600);
  EXPECT_EQ(entries[3].index, 0x6001);
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_EQ(file.notes[0].text, "an entry of 600 bits: the first 255 of them, the rest a gap");
}

TEST(EsiLenience, EntriesOfNoBitsAreToldOf) {
  const auto file = read_device(
      "<TxPdo><Index>#x1A00</Index><Entry><Index>#x6000</Index><BitLen>0</BitLen></Entry>"
      "<Entry><Index>#x0</Index><BitLen>0</BitLen></Entry></TxPdo>");
  EXPECT_EQ(file.devices.at(0).tx_pdos.at(0).entries.size(), 2U);
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_EQ(file.notes[0].text, "an entry of 0 bits: it is in no process data");
}

TEST(EsiLenience, EntriesWithoutAKnownTypeAreNumbersOfTheirLength) {
  const auto file = read_device(
      "<TxPdo><Index>#x1A00</Index><Entry><Index>#x6000</Index><BitLen>1</BitLen></Entry>"
      "<Entry><Index>#x6001</Index><BitLen>2</BitLen><DataType>DT0800EN02</DataType></Entry>"
      "<Entry><Index>#x6002</Index><BitLen>64</BitLen></Entry>"
      "<Entry><Index>#x6003</Index><BitLen>24</BitLen></Entry></TxPdo>");
  std::vector<DataType> types;
  for (const auto& entry : file.devices.at(0).tx_pdos.at(0).entries) types.push_back(entry.type);
  EXPECT_THAT(types, ElementsAre(DataType::kBit1, DataType::kBit2, DataType::kUnsigned64, DataType::kOctetString));
}

TEST(EsiLenience, PlacesOfEntriesInTheirObject) {
  const auto record = [](const std::string& second, const std::string& third) {
    return read_device(
               "<Profile><Dictionary><DataTypes><DataType><Name>R</Name><BitSize>64</BitSize>"
               "<SubItem><SubIdx>0</SubIdx><Name>N</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs></"
               "SubItem>"
               "<SubItem><SubIdx>1</SubIdx><Name>A</Name><Type>BIT3</Type><BitSize>3</BitSize>" +
               second + "</SubItem><SubItem><SubIdx>2</SubIdx><Name>B</Name><Type>UINT</Type><BitSize>16</BitSize>" +
               third +
               "</SubItem></DataType></DataTypes><Objects><Object><Index>#x8000</Index><Type>R</Type></Object></"
               "Objects>"
               "</Dictionary></Profile>")
        .devices.at(0)
        .objects.at(0)
        .entries;
  };
  const auto usual = record("<BitOffs>16</BitOffs>", "<BitOffs>19</BitOffs>");
  EXPECT_FALSE(usual[0].bit_offset || usual[1].bit_offset || usual[2].bit_offset);
  const auto missing = record("", "");
  EXPECT_FALSE(missing[1].bit_offset || missing[2].bit_offset);
  const auto padded = record("<BitOffs>16</BitOffs>", "<BitOffs>32</BitOffs>");
  EXPECT_EQ(padded[2].bit_offset, 32U);
  const auto silly = record("<BitOffs>16</BitOffs>", "<BitOffs>4294967295</BitOffs>");
  EXPECT_FALSE(silly[2].bit_offset);
}

TEST(EsiLenience, PlacesAreWrittenAndReadBack) {
  DeviceDescription device;
  device.vendor_id = 1;
  device.type = "X";
  device.name = "X";
  Object object{0x8000, "Padded", ObjectCode::kRecord, {}};
  object.entries = {{0, "SubIndex 000", DataType::kUnsigned8, 8, true, false, false, false, "02", "", ""},
                    {1, "A", DataType::kBit3, 3, true, true, false, false, "", "", ""},
                    {2, "B", DataType::kUnsigned16, 16, true, true, false, false, "", "", "", 32},
                    {3, "C", DataType::kUnsigned16, 16, true, true, false, false, "", "", ""}};
  device.objects = {object};
  device.tx_pdos = {{0x1A00, "In", false, false, 3, {}, {0x1A01, 0x1A02}}};
  const EsiFile file = read(write_esi({device}));
  EXPECT_EQ(file.devices.at(0).objects, device.objects);
  EXPECT_EQ(file.devices.at(0).tx_pdos, device.tx_pdos);
}

}  // namespace
}  // namespace driveline::esi
