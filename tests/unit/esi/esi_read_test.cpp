#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/esi/esi_library.hpp"
#include "support/must.hpp"

namespace driveline::esi {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A file as vendors write them, typed by hand: two revisions, names in two languages, CDATA, all number formats,
/// elements unknown to the reader, types declared in the dictionary.
constexpr std::string_view kVendorFile = R"(<?xml version="1.0" encoding="ISO8859-1"?>
<!-- a comment -->
<EtherCATInfo xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" Version="1.2">
  <Vendor FileVersion="3"><Id>106</Id><Name LcId="1031"><![CDATA[Antriebe]]></Name><Name>Drives Inc</Name></Vendor>
  <Descriptions>
    <Groups>
      <Group SortOrder="10"><Type>Drive</Type><Name LcId="1031">Antriebe</Name><Name LcId="1033">Drives</Name></Group>
    </Groups>
    <Devices>
      <Device Physics="YY">
        <Type ProductCode="#x00414b44" RevisionNo="#x1" CheckRevisionNo="EQ_OR_G">D1</Type>
        <Name LcId="1031"><![CDATA[Servoregler]]></Name>
        <Name LcId="1033"><![CDATA[
          Servo <drive>
        ]]></Name>
        <URL>http://example.org</URL>
        <GroupType>Drive</GroupType>
        <Fmmu>Outputs</Fmmu><Fmmu Sm="3">inputs</Fmmu><Fmmu>DynamicThing</Fmmu>
        <Sm MinSize="#x30" MaxSize="1024" DefaultSize="0x200" StartAddress="#x1800" ControlByte="#x26" Enable="1">MBoxOut</Sm>
        <Sm StartAddress="#x1c00" ControlByte="#X22" Enable="true">MBoxIn</Sm>
        <Sm StartAddress="4352" Enable="#x0" ControlByte="0x64">Outputs</Sm>
        <RxPdo Fixed="true" Mandatory="0" Sm="2">
          <Index DependOnSlot="1">#x1701</Index>
          <Name><![CDATA[Outputs]]></Name>
          <Exclude>#x1702</Exclude>
          <Entry Fixed="1"><Index>#x60C1</Index><SubIndex>#x1</SubIndex><BitLen>32</BitLen><Name>Set</Name><DataType>DINT</DataType></Entry>
          <Entry><Index>0</Index><BitLen>4</BitLen></Entry>
          <Entry><Index>#x6040</Index><BitLen>16</BitLen><Name>Control</Name><DataType>DT_VENDOR</DataType></Entry>
        </RxPdo>
        <TxPdo><Index>#x1B01</Index><Name>Inputs</Name></TxPdo>
        <Mailbox DataLinkLayer="true"><EoE IP="1"/><CoE SdoInfo="1" PdoAssign="true" PdoConfig="0" CompleteAccess="false"><InitCmd/></CoE></Mailbox>
        <Dc><OpMode><Name>DcSync</Name><Desc>DC synchron</Desc><AssignActivate>#x300</AssignActivate>
          <CycleTimeSync0 Factor="1">0</CycleTimeSync0><ShiftTimeSync0 Input="1">-1500</ShiftTimeSync0></OpMode></Dc>
        <Slots><Slot/></Slots>
        <Eeprom><ByteSize>2048</ByteSize><ConfigData>0900000800000000000000000000</ConfigData><BootStrap>00180004001c0004</BootStrap></Eeprom>
        <Image16x14>4D42</Image16x14>
        <VendorSpecific><Anything a="b">1<Deep/></Anything></VendorSpecific>
      </Device>
      <Device Physics="YY">
        <Type ProductCode="#x00414B44" RevisionNo="2">D1</Type>
        <Profile>
          <ProfileNo>402</ProfileNo>
          <Dictionary>
            <DataTypes>
              <DataType><Name>UDINT</Name><BitSize>32</BitSize></DataType>
              <DataType><Name>DT1018</Name><BitSize>80</BitSize>
                <SubItem><SubIdx>0</SubIdx><Name>Count</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs><Flags><Access>ro</Access></Flags></SubItem>
                <SubItem><SubIdx>1</SubIdx><Name>Vendor</Name><Type>UDINT</Type><BitSize>32</BitSize><BitOffs>16</BitOffs><Flags><Access>rw</Access><PdoMapping>tr</PdoMapping></Flags></SubItem>
                <SubItem><SubIdx>4</SubIdx><Name>Serial</Name><Type>UDINT</Type><BitSize>32</BitSize><BitOffs>48</BitOffs></SubItem>
              </DataType>
              <DataType><Name>DT607DARR</Name><BaseType>DINT</BaseType><BitSize>64</BitSize><ArrayInfo><LBound>1</LBound><Elements>2</Elements></ArrayInfo></DataType>
              <DataType><Name>DT607D</Name><BitSize>80</BitSize>
                <SubItem><SubIdx>0</SubIdx><Name>SubIndex 000</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem>
                <SubItem><Name>Elements</Name><Type>DT607DARR</Type><BitSize>64</BitSize><BitOffs>16</BitOffs><Flags><Access>rw</Access></Flags></SubItem>
              </DataType>
              <DataType><Name>ENUM8</Name><BaseType>SINT</BaseType><BitSize>8</BitSize><EnumInfo><Text>a</Text><Enum>1</Enum></EnumInfo></DataType>
            </DataTypes>
            <Objects>
              <Object><Index>#x607D</Index><Name>Limits</Name><Type>DT607D</Type><BitSize>80</BitSize>
                <Info><SubItem><Name>SubIndex 000</Name><Info><DefaultData>02</DefaultData></Info></SubItem>
                      <SubItem><Name>Minimum</Name><Info><DefaultValue>-2</DefaultValue></Info></SubItem></Info>
                <Flags><Access>ro</Access></Flags></Object>
              <Object><Index>#x1018</Index><Name>Identity</Name><Type>DT1018</Type><BitSize>80</BitSize>
                <Info><SubItem><Name>Serial</Name><Info><DefaultData>0a0b0c0d</DefaultData></Info></SubItem></Info>
                <Flags><Access>wo</Access></Flags></Object>
              <Object><Index>#x6060</Index><Name>Mode</Name><Type>ENUM8</Type><BitSize>8</BitSize>
                <Info><DefaultValue>8</DefaultValue><MinValue>-128</MinValue></Info><Flags><Access>rw</Access><PdoMapping>R</PdoMapping></Flags></Object>
              <Object><Index>#x1008</Index><Name>Device name</Name><Type>STRING(2)</Type><BitSize>16</BitSize>
                <Info><DefaultString>D1</DefaultString></Info></Object>
            </Objects>
          </Dictionary>
        </Profile>
      </Device>
    </Devices>
    <Modules><Module/></Modules>
  </Descriptions>
</EtherCATInfo>
)";

EsiFile vendor_file() {
  auto file = read_esi(kVendorFile, "vendor.xml");
  EXPECT_TRUE(file) << to_text(file.error());
  return file.value_or(EsiFile{});
}

TEST(ReadEsi, VendorAndIdentities) {
  const EsiFile file = vendor_file();
  EXPECT_EQ(file.vendor_id, 106U);
  EXPECT_EQ(file.vendor_name, "Antriebe");  // no English name there: the first
  ASSERT_EQ(file.devices.size(), 2U);
  EXPECT_EQ(file.devices[0].product_code, 0x00414B44U);
  EXPECT_EQ(file.devices[0].revision, 1U);
  EXPECT_EQ(file.devices[1].revision, 2U);
  EXPECT_EQ(file.devices[0].type, "D1");
  EXPECT_EQ(file.devices[0].name, "Servo <drive>");
  EXPECT_EQ(file.devices[0].group_type, "Drive");
  EXPECT_EQ(file.devices[0].group_name, "Drives");
  EXPECT_EQ(file.devices[0].vendor_id, 106U);
}

TEST(ReadEsi, FindDevice) {
  const EsiFile file = vendor_file();
  EXPECT_EQ(file.find_device(106, 0x414B44, 2), &file.devices[1]);
  EXPECT_EQ(file.find_device(106, 0x414B44, 3), nullptr);
  EXPECT_EQ(file.find_device(107, 0x414B44, 2), nullptr);
  EXPECT_EQ(file.find_device(106, 0x414B45, 2), nullptr);
}

TEST(ReadEsi, FmmusSyncManagersPdos) {
  const DeviceDescription device = vendor_file().devices.at(0);
  EXPECT_THAT(device.fmmus, ElementsAre(FmmuUse::kOutputs, FmmuUse::kInputs, FmmuUse::kUnused));
  EXPECT_THAT(device.sync_managers,
              ElementsAre(SyncManager{SyncManager::Use::kMailboxOut, 0x1800, 512, 48, 1024, 0x26, true},
                          SyncManager{SyncManager::Use::kMailboxIn, 0x1C00, 0, 0, 0, 0x22, true},
                          SyncManager{SyncManager::Use::kOutputs, 0x1100, 0, 0, 0, 0x64, false}));
  EXPECT_THAT(device.rx_pdos, ElementsAre(Pdo{0x1701,
                                              "Outputs",
                                              true,
                                              false,
                                              2,
                                              {{0x60C1, 1, 32, "Set", DataType::kInteger32},
                                               {0, 0, 4, "", DataType::kUnsigned8},
                                               {0x6040, 0, 16, "Control", DataType::kUnsigned16}},
                                              {0x1702}}));
  EXPECT_THAT(device.tx_pdos, ElementsAre(Pdo{0x1B01, "Inputs", false, false, std::nullopt, {}}));
}

TEST(ReadEsi, MailboxClockEeprom) {
  const DeviceDescription device = vendor_file().devices.at(0);
  MailboxSupport mailbox;
  mailbox.eoe = mailbox.eoe_ip = mailbox.coe = mailbox.coe_sdo_info = mailbox.coe_pdo_assign = true;
  EXPECT_EQ(device.mailbox, mailbox);
  EXPECT_THAT(device.dc_modes, ElementsAre(DcOpMode{"DcSync", "DC synchron", 0x300, 0, 1, -1500, 0, 0, 0}));
  EXPECT_EQ(device.eeprom_bytes, 2048U);
  EXPECT_EQ(device.eeprom_config_data_hex, "0900000800000000000000000000");
  EXPECT_EQ(device.bootstrap_rx_offset, 0x1800);
  EXPECT_EQ(device.bootstrap_rx_size, 0x400);
  EXPECT_EQ(device.bootstrap_tx_offset, 0x1C00);
  EXPECT_EQ(device.bootstrap_tx_size, 0x400);
}

TEST(ReadEsi, ObjectsAreResolvedByTheirTypes) {
  const DeviceDescription device = vendor_file().devices.at(1);
  EXPECT_EQ(device.device_profile, 402);
  ASSERT_EQ(device.objects.size(), 4U);  // ascending, the file has them in another order
  const Object& name = device.objects[0];
  EXPECT_EQ(name.index, 0x1008);
  EXPECT_THAT(name.entries, ElementsAre(ObjectEntry{0, "Device name", DataType::kVisibleString, 16, true, false, false,
                                                    false, "4431", "", ""}));
  const Object& identity = device.objects[1];
  EXPECT_EQ(identity.code, ObjectCode::kRecord);
  EXPECT_THAT(
      identity.entries,
      ElementsAre(ObjectEntry{0, "Count", DataType::kUnsigned8, 8, true, false, false, false, "", "", ""},
                  ObjectEntry{1, "Vendor", DataType::kUnsigned32, 32, true, true, true, true, "", "", ""},
                  ObjectEntry{4, "Serial", DataType::kUnsigned32, 32, false, true, false, false, "0A0B0C0D", "", ""}));
  const Object& mode = device.objects[2];
  EXPECT_EQ(mode.index, 0x6060);
  EXPECT_THAT(mode.entries,
              ElementsAre(ObjectEntry{0, "Mode", DataType::kInteger8, 8, true, true, true, false, "08", "80", ""}));
  const Object& limits = device.objects[3];
  EXPECT_EQ(limits.code, ObjectCode::kArray);
  EXPECT_THAT(
      limits.entries,
      ElementsAre(ObjectEntry{0, "SubIndex 000", DataType::kUnsigned8, 8, true, false, false, false, "02", "", ""},
                  ObjectEntry{1, "Minimum", DataType::kInteger32, 32, true, true, false, false, "FEFFFFFF", "", ""},
                  ObjectEntry{2, "SubIndex 002", DataType::kInteger32, 32, true, true, false, false, "", "", ""}));
}

TEST(ReadEsi, NotesSayWhatWasLeftOut) {
  std::vector<std::string> notes;
  for (const auto& note : vendor_file().notes) {
    notes.push_back(std::to_string(note.line) + " " + note.path + ": " + note.text);
  }
  const std::string devices = "EtherCATInfo/Descriptions/Devices/";
  EXPECT_THAT(
      notes, ElementsAre("18 " + devices + "Device[1]/Fmmu[3]: the use 'DynamicThing' is not known; taken as unused",
                         "28 " + devices +
                             "Device[1]/RxPdo/Entry[3]/DataType: the type 'DT_VENDOR' is taken as a number of 16 bits",
                         "31 " + devices + "Device[1]/Mailbox/CoE/InitCmd: a start-up command without Index is ignored",
                         "34 " + devices + "Device[1]/Slots: slots are not read",
                         "75 EtherCATInfo/Descriptions/Modules: modules are not read"));
}

TEST(ReadEsi, NotesAreLimited) {
  std::string text =
      "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device><Type ProductCode='1' "
      "RevisionNo='1'/>";
  for (int i = 0; i < 5000; ++i) text += "<Fmmu>odd</Fmmu>";
  text += "</Device></Devices></Descriptions></EtherCATInfo>";
  const auto file = must(read_esi(text, "f.xml"));
  EXPECT_EQ(file->notes.size(), 201U);
  EXPECT_THAT(file->notes.back().text, HasSubstr("further notes are omitted"));
}

TEST(ReadEsi, SmallestFile) {
  const auto file = must(read_esi("<EtherCATInfo><Vendor><Id>#xFFFFFFFF</Id></Vendor></EtherCATInfo>", "f.xml"));
  EXPECT_EQ(file->vendor_id, 0xFFFFFFFFU);
  EXPECT_TRUE(file->devices.empty());
  EXPECT_TRUE(file->notes.empty());
}

TEST(ReadEsi, TextsInIso8859BecomeUtf8) {
  const auto file =
      must(read_esi("<EtherCATInfo><Vendor><Id>1</Id><Name>Gr\xFC\xDF"
                    "e</Name></Vendor></EtherCATInfo>",
                    "f.xml"));
  EXPECT_EQ(file->vendor_name,
            "Gr\xC3\xBC\xC3\x9F"
            "e");
}

TEST(ReadEsi, EepromThatTheApplicationReads) {
  EXPECT_FALSE(vendor_file().devices.at(0).eeprom_to_application);
  for (const auto& [attribute, expected] :
       {std::pair{"AssignToPdi=\"1\"", true}, std::pair{"AssignToPdi=\"true\"", true},
        std::pair{"AssignToPdi=\"0\"", false}}) {
    const auto file =
        read_esi("<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device><Type/><Eeprom " +
                     std::string(attribute) +
                     "><ByteSize>2048</ByteSize></Eeprom></Device></Devices></Descriptions></EtherCATInfo>",
                 "f.xml");
    ASSERT_TRUE(file) << attribute;
    EXPECT_EQ(file->devices.at(0).eeprom_to_application, expected) << attribute;
  }
}

TEST(ReadEsi, CompleteEepromImage) {
  std::string data = "0102030405060708090A0B0C0D0E" + std::string(2 * 26, '0') + "0010200000113000";
  const auto file =
      must(read_esi("<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device><Type/><Eeprom>"
                    "<Data>" +
                        data + "</Data></Eeprom></Device></Devices></Descriptions></EtherCATInfo>",
                    "f.xml"));
  EXPECT_EQ(file->devices.at(0).eeprom_config_data_hex, "0102030405060708090A0B0C0D0E");
  EXPECT_EQ(file->devices[0].bootstrap_rx_offset, 0x1000);
  EXPECT_EQ(file->devices[0].bootstrap_tx_size, 0x30);
}

/// The message for a file with one line per element, the device element starting in line 5.
std::string message(std::string_view device_content) {
  const auto file = read_esi("<EtherCATInfo>\n<Vendor><Id>1</Id></Vendor>\n<Descriptions>\n<Devices>\n<Device>\n" +
                                 std::string(device_content) + "\n</Device>\n</Devices></Descriptions></EtherCATInfo>",
                             "f.xml");
  return file ? "no error" : to_text(file.error());
}

TEST(ReadEsiErrors, NameFileLineElementAndWhatWasExpected) {
  const std::string device = "EtherCATInfo/Descriptions/Devices/Device";
  EXPECT_EQ(message(""),
            "f.xml:5: " + device + ": a device without type, expected Type with ProductCode and RevisionNo");
  EXPECT_EQ(message("<Type ProductCode='abc'/>"),
            "f.xml:6: " + device + "/Type: 'abc', expected a number from 0 to 4294967295 as 16, #x10 or 0x10");
  EXPECT_EQ(message("<Type/>\n\n<Sm/>\n<Sm StartAddress='#x10000'/>"),
            "f.xml:9: " + device + "/Sm[2]: '#x10000', expected a number from 0 to 65535 as 16, #x10 or 0x10");
  EXPECT_EQ(message("<Type/><RxPdo Fixed='yes'><Index>1</Index></RxPdo>"),
            "f.xml:6: " + device + "/RxPdo: Fixed='yes', expected true, false or a number");
  EXPECT_EQ(message("<Type/><TxPdo/>"),
            "f.xml:6: " + device + "/TxPdo: a PDO without Index, expected Index, e.g. #x1600");
  EXPECT_EQ(message("<Type/><TxPdo><Index>1</Index><Entry/></TxPdo>"),
            "f.xml:6: " + device + "/TxPdo/Entry: a PDO entry without BitLen, expected BitLen, 1 to 255");
  EXPECT_EQ(message("<Type/><Eeprom><ConfigData>0G</ConfigData></Eeprom>"),
            "f.xml:6: " + device + "/Eeprom/ConfigData: '0G', expected hexadecimal digits, two for each byte");
  EXPECT_EQ(message("<Type/><Eeprom><ConfigData>123</ConfigData></Eeprom>"),
            "f.xml:6: " + device + "/Eeprom/ConfigData: '123', expected hexadecimal digits, two for each byte");
}

TEST(ReadEsiErrors, Numbers) {
  for (const char* bad :
       {"", " ", "#x", "0x", "#xG", "12 13", "1.5", "-1", "4294967296", "#x100000000", "+-1", "#x-1", "1e3"}) {
    EXPECT_THAT(message("<Type ProductCode='" + std::string(bad) + "'/>"), HasSubstr("expected a number")) << bad;
  }
  for (const char* good : {"0", " 7 ", "+7", "#xffffFFFF", "0X1", "4294967295", "007"}) {
    EXPECT_EQ(message("<Type ProductCode='" + std::string(good) + "'/>"), "no error") << good;
  }
}

TEST(ReadEsiErrors, Dictionary) {
  const auto dictionary = [](const std::string& types, const std::string& objects) {
    return message("<Type/><Profile><Dictionary><DataTypes>" + types + "</DataTypes><Objects>" + objects +
                   "</Objects></Dictionary></Profile>");
  };
  EXPECT_THAT(dictionary("", "<Object/>"), HasSubstr("an object without Index"));
  EXPECT_THAT(dictionary("", "<Object><Index>1</Index><Type>USINT</Type><Flags><Access>x</Access></Flags></Object>"),
              HasSubstr("Flags/Access: 'x', expected ro, rw or wo"));
  const std::string huge =
      "<DataType><Name>A</Name><BaseType>USINT</BaseType><ArrayInfo><LBound>1</LBound><Elements>4000000000</Elements>"
      "</ArrayInfo></DataType>";
  EXPECT_THAT(dictionary(huge, "<Object><Index>1</Index><Type>A</Type></Object>"),
              HasSubstr("an array of 4000000000 elements from 1, expected sub-indices up to 255"));
  const std::string record =
      "<DataType><Name>R</Name><SubItem><SubIdx>256</SubIdx><Type>USINT</Type></SubItem></DataType>";
  EXPECT_THAT(dictionary(record, "<Object><Index>1</Index><Type>R</Type></Object>"), HasSubstr("sub-index 256"));
  const std::string recursive = "<DataType><Name>R</Name><SubItem><Type>R</Type></SubItem></DataType>";
  EXPECT_EQ(dictionary(recursive, "<Object><Index>1</Index><Type>R</Type></Object>"), "no error");
}

TEST(ReadEsiErrors, FileAsAWhole) {
  const auto text = [](std::string_view xml) {
    const auto file = read_esi(xml, "f.xml");
    return file ? "no error" : to_text(file.error());
  };
  EXPECT_THAT(text(""), HasSubstr("f.xml:1: not well-formed XML"));
  EXPECT_THAT(text("<EtherCATInfo>\n<Vendor>\n</EtherCATInfo>"), HasSubstr("f.xml:3: not well-formed XML"));
  EXPECT_EQ(text("\n<html/>"), "f.xml:2: html: the root element is 'html', expected EtherCATInfo");
  EXPECT_EQ(text("<EtherCATInfo/>"), "f.xml:1: EtherCATInfo: no vendor id, expected Vendor/Id, e.g. #x00000002");
  EXPECT_THAT(text("<EtherCATInfo><Vendor><Id/></Vendor></EtherCATInfo>"),
              HasSubstr("Vendor/Id: '', expected a number"));
}

TEST(ReadEsiErrors, OffsetPointsToTheElement) {
  constexpr std::string_view kXml = "<EtherCATInfo>\n  <Vendor><Id>x</Id></Vendor></EtherCATInfo>";
  const auto file = read_esi(kXml, "f.xml");
  ASSERT_FALSE(file);
  EXPECT_EQ(kXml.substr(file.error().offset, 2), "Id");
  EXPECT_EQ(file.error().path, "EtherCATInfo/Vendor/Id");
}

/// Typed by hand from the schema, with typical content of servo drives of several vendors.
constexpr std::string_view kForMasters = R"(<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices>
  <Device><Type ProductCode="2" RevisionNo="3" UseLrdLwr="true">D</Type>
    <Info><StateMachine><Timeout><PreopTimeout>2000</PreopTimeout><SafeopOpTimeout>9000</SafeopOpTimeout>
      <BackToInitTimeout>5000</BackToInitTimeout><BackToSafeopTimeout>200</BackToSafeopTimeout></Timeout></StateMachine>
      <Mailbox><Timeout><RequestTimeout>100</RequestTimeout><ResponseTimeout>4000</ResponseTimeout></Timeout></Mailbox>
      <IdentificationReg134>true</IdentificationReg134></Info>
    <Mailbox><CoE>
      <InitCmd Fixed="1"><Transition>PS</Transition><Index>#x1c12</Index><SubIndex>0</SubIndex><Data>0a00</Data><Comment>x</Comment></InitCmd>
      <InitCmd CompleteAccess="true"><Transition>so</Transition><Transition>PS</Transition><Index>8193</Index><SubIndex>0</SubIndex><Data>01</Data></InitCmd>
      <InitCmd><Transition>OS</Transition><Index>1</Index><Data>01</Data></InitCmd></CoE></Mailbox>
    <Esc><Reg0400>#x09c2</Reg0400><Reg0420>500</Reg0420></Esc></Device>
</Devices></Descriptions></EtherCATInfo>)";

TEST(ReadEsi, WhatAMasterNeeds) {
  const auto file = must(read_esi(kForMasters, "d.xml"));
  const auto& device = file->devices.at(0);
  EXPECT_TRUE(device.not_lrw);
  EXPECT_TRUE(device.identification);
  EXPECT_EQ(device.timeouts, (DeviceTimeouts{2000, 9000, 5000, 200, 100, 4000}));
  EXPECT_EQ(device.watchdogs, (DeviceWatchdogs{2498, std::nullopt, 500}));
  ASSERT_EQ(device.init_commands.size(), 3U);
  EXPECT_EQ(device.init_commands[0], (InitCommand{{"PS"}, 0x1C12, 0, "0A00", false}));
  EXPECT_EQ(device.init_commands[1], (InitCommand{{"SO", "PS"}, 0x2001, 0, "01", true}));
  ASSERT_EQ(file->notes.size(), 1U);
  EXPECT_THAT(file->notes[0].text, HasSubstr("none of the transitions IP, PS and SO"));
}

TEST(ReadEsi, StartUpCommandWithoutIndexIsPassedOverAndWrongDataRefused) {
  std::string text(kForMasters);
  text.replace(text.find("<Index>8193</Index>"), 19, "");
  const auto no_index = must(read_esi(text, "d.xml"));
  EXPECT_EQ(no_index->devices.at(0).init_commands.size(), 2U);
  ASSERT_EQ(no_index->notes.size(), 2U);
  EXPECT_EQ(no_index->notes[0].text, "a start-up command without Index is ignored");
  text = kForMasters;
  text.replace(text.find("0a00"), 4, "0a0x");
  EXPECT_FALSE(read_esi(text, "d.xml"));
}

TEST(EsiLibraryTest, FindsTheRevisionOrTheNextBelow) {
  EsiLibrary library;
  const auto file = [](std::uint32_t revision, const char* name) {
    EsiFile made;
    DeviceDescription device;
    device.vendor_id = 1;
    device.product_code = 2;
    device.revision = revision;
    device.name = name;
    made.devices = {device};
    return made;
  };
  library.add(file(10, "ten"));
  library.add(file(30, "thirty"));
  library.add(file(10, "ten once more"));
  EXPECT_EQ(library.size(), 2U);
  EXPECT_EQ(library.find(1, 2, 10)->name, "ten");
  EXPECT_EQ(library.find(1, 2, 29)->name, "ten");
  EXPECT_EQ(library.find(1, 2, 31)->name, "thirty");
  EXPECT_EQ(library.find(1, 2, 9), nullptr) << "older than every description";
  EXPECT_EQ(library.find(1, 3, 10), nullptr);
  EXPECT_EQ(library.find(2, 2, 10), nullptr);
}

}  // namespace
}  // namespace driveline::esi
