#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/esi/esi_file.hpp"
#include "sample_device.hpp"
#include "support/must.hpp"

namespace driveline::esi {
namespace {

using test::random_device;
using test::sample_device;
using ::testing::HasSubstr;

/// The part of `text` from `begin` to `end`, both included.
std::string part(const std::string& text, std::string_view begin, std::string_view end) {
  const auto from = text.find(begin);
  const auto to = text.find(end, from);
  return from == std::string::npos || to == std::string::npos ? "" : text.substr(from, to + end.size() - from);
}

TEST(WriteEsi, ElementsOfTheSchema) {
  const std::string xml = write_esi({sample_device()});
  EXPECT_THAT(xml, HasSubstr("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<EtherCATInfo "));
  EXPECT_THAT(xml, HasSubstr("<Id>#x0000ABCD</Id>\n    <Name LcId=\"1033\">Drives &amp; Co. &lt;GmbH&gt;</Name>"));
  EXPECT_THAT(
      xml, HasSubstr("<Type ProductCode=\"#x00401234\" RevisionNo=\"#x00010002\" SerialNo=\"#x00001267\">SD-1</Type>"));
  EXPECT_THAT(xml, HasSubstr("<Sm MinSize=\"48\" MaxSize=\"1024\" DefaultSize=\"512\" StartAddress=\"#x1800\" "
                             "ControlByte=\"#x26\" Enable=\"1\">MBoxOut</Sm>"));
  EXPECT_THAT(xml,
              HasSubstr("<CoE SdoInfo=\"1\" PdoAssign=\"1\" PdoConfig=\"1\" PdoUpload=\"1\" CompleteAccess=\"1\" />"));
  EXPECT_THAT(xml,
              HasSubstr("<ByteSize>4096</ByteSize>\n          <ConfigData>05060344640000000000000A0000</ConfigData>\n"
                        "          <BootStrap>0010000100128000</BootStrap>"));
}

TEST(WriteEsi, PdoWithGap) {
  EXPECT_EQ(part(write_esi({sample_device()}), "<TxPdo", "</TxPdo>"), R"(<TxPdo Fixed="1" Sm="3">
          <Index>#x1A00</Index>
          <Name LcId="1033">Inputs</Name>
          <Entry>
            <Index>#x6041</Index>
            <SubIndex>0</SubIndex>
            <BitLen>16</BitLen>
            <Name LcId="1033">Status word</Name>
            <DataType>UINT</DataType>
          </Entry>
          <Entry>
            <Index>#x0000</Index>
            <BitLen>8</BitLen>
          </Entry>
          <Entry>
            <Index>#x6064</Index>
            <SubIndex>0</SubIndex>
            <BitLen>32</BitLen>
            <Name LcId="1033">Position actual value</Name>
            <DataType>DINT</DataType>
          </Entry>
        </TxPdo>)");
}

TEST(WriteEsi, ArrayTypes) {
  const std::string xml = write_esi({sample_device()});
  EXPECT_EQ(part(xml, "<DataType>\n                <Name>DT607DARR", "</DataType>"), R"(<DataType>
                <Name>DT607DARR</Name>
                <BaseType>DINT</BaseType>
                <BitSize>64</BitSize>
                <ArrayInfo>
                  <LBound>1</LBound>
                  <Elements>2</Elements>
                </ArrayInfo>
              </DataType>)");
  EXPECT_THAT(xml, HasSubstr("<Name>ARRAY [0..15] OF BYTE</Name>"));
}

TEST(WriteEsi, VariableWithAccessAndMapping) {
  EXPECT_EQ(part(write_esi({sample_device()}), "<Object>\n                <Index>#x607A", "</Object>"), R"(<Object>
                <Index>#x607A</Index>
                <Name LcId="1033">Target position</Name>
                <Type>DINT</Type>
                <BitSize>32</BitSize>
                <Info>
                  <DefaultData>00000000</DefaultData>
                </Info>
                <Flags>
                  <Access>rw</Access>
                  <PdoMapping>RT</PdoMapping>
                </Flags>
              </Object>)");
}

TEST(WriteEsi, EqualInputGivesEqualBytes) {
  EXPECT_EQ(write_esi({sample_device(), sample_device()}), write_esi({sample_device(), sample_device()}));
}

TEST(WriteEsi, ReadsBackEqual) {
  DeviceDescription next = sample_device();
  next.revision += 1;
  next.objects.clear();
  const std::vector<DeviceDescription> devices{sample_device(), next};
  const auto file = must(read_esi(write_esi(devices), "own.xml"));
  EXPECT_EQ(file->devices, devices);
  EXPECT_EQ(file->vendor_id, 0xABCDU);
  EXPECT_TRUE(file->notes.empty()) << file->notes[0].text;
}

TEST(WriteEsi, WhatAMasterNeedsReadsBackEqual) {
  auto device = sample_device();
  device.not_lrw = true;
  device.identification = true;
  device.timeouts = {2000, 9000, 5000, 200, 100, 4000};
  device.watchdogs = {2498, std::nullopt, 500};
  device.init_commands = {{{"PS"}, 0x8000, 3, "6400", false}, {{"IP", "SO"}, 0x8001, 0, "0102", true}};
  const auto file = must(read_esi(write_esi({device}), "written.xml"));
  EXPECT_EQ(file->devices.at(0), device);
  EXPECT_TRUE(file->notes.empty());
  device.timeouts = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 1500};
  EXPECT_EQ(read_esi(write_esi({device}), "written.xml").value().devices.at(0), device);
  device.timeouts = {};
  EXPECT_EQ(read_esi(write_esi({device}), "written.xml").value().devices.at(0), device);
}

TEST(WriteEsi, EepromThatTheApplicationReadsReadsBackEqual) {
  auto device = sample_device();
  device.eeprom_to_application = true;
  const auto xml = write_esi({device});
  EXPECT_THAT(xml, HasSubstr("<Eeprom AssignToPdi=\"1\">"));
  EXPECT_TRUE(read_esi(xml, "f.xml").value().devices.at(0).eeprom_to_application);
}

TEST(WriteEsi, RandomDevicesReadBackEqual) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const std::vector<DeviceDescription> devices{random_device(random), random_device(random)};
    const std::string xml = write_esi(devices);
    const auto file = must(read_esi(xml, "own.xml"));
    ASSERT_EQ(file->devices, devices) << xml;
  }
}

TEST(WriteEsi, NoDevices) {
  const auto file = must(read_esi(write_esi({}), "own.xml"));
  EXPECT_TRUE(file->devices.empty());
}

TEST(WriteEsi, ArrayWithUnequalElementsBecomesARecord) {
  DeviceDescription device = sample_device();
  device.objects.back().entries.back().bit_length = 16;
  device.objects.back().entries.back().type = DataType::kInteger16;
  const auto file = must(read_esi(write_esi({device}), "own.xml"));
  device.objects.back().code = ObjectCode::kRecord;
  EXPECT_EQ(file->devices.at(0).objects, device.objects);
}

TEST(WriteEsi, TextsThatXmlCannotHold) {
  DeviceDescription device = sample_device();
  device.name = std::string("bell\x07") + "M\xFCller";  // a control character, and ISO 8859-1 as SII images have it
  EXPECT_EQ(must(read_esi(write_esi({device}), "own.xml"))->devices.at(0).name, "bell M\xC3\xBCller");
}

}  // namespace
}  // namespace driveline::esi
