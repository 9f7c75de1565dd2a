// Electronic data sheets and device configuration files as vendors write them, read with the rules of CiA 306-1.
#include <gmock/gmock.h>

#include "driveline/esi/eds_file.hpp"

namespace driveline::esi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A drive in the style of a vendor's tool: CRLF, comments, formulas, compact entries, all number formats.
constexpr auto kDrive =
    "; generated\r\n[FileInfo]\r\nFileName=drive.eds\r\nEDSVersion=4.0\r\n"
    "[DeviceInfo]\r\nVendorName=M\xFCller\r\nVendorNumber=0x28\r\nProductName=Drive 5\r\nProductNumber=4660\r\n"
    "RevisionNumber=017\r\nOrderCode=G392\r\nBaudRate_20=0\r\nBaudRate_125=1\r\nBaudRate_1000=1\r\n"
    "LSS_Supported=1\r\n"
    "[DummyUsage]\r\nDummy0005=1\r\n"
    "[MandatoryObjects]\r\nSupportedObjects=2\r\n1=0x1000\r\n2=0x1018\r\n"
    "[1000]\r\nParameterName=Device type\r\nObjectType=0x7\r\nDataType=0x0007\r\nAccessType=ro\r\n"
    "DefaultValue=0x00020192\r\nPDOMapping=0\r\n"
    "[1018]\r\nParameterName=Identity\r\nObjectType=0x9\r\nSubNumber=2\r\n"
    "[1018sub0]\r\nParameterName=Entries\r\nObjectType=0x7\r\nDataType=0x0005\r\nAccessType=const\r\n"
    "DefaultValue=1\r\n"
    "[1018Sub1]\r\nParameterName=Vendor\r\nObjectType=0x7\r\nDataType=0x0007\r\nAccessType=ro\r\n"
    "DefaultValue=40\r\n"
    "[OptionalObjects]\r\nSupportedObjects=5\r\n1=0x1003\r\n2=0x1014\r\n3=0x1400\r\n4=0x1A00\r\n5=0x6064\r\n"
    "[1003]\r\nParameterName=Errors\r\nObjectType=8\r\nDataType=7\r\nAccessType=ro\r\nCompactSubObj=3\r\n"
    "[1003Name]\r\nNrOfEntries=1\r\n2=Older one\r\n"
    "[1003sub3]\r\nParameterName=Oldest\r\nDataType=7\r\nAccessType=rw\r\n"
    "[1014]\r\nParameterName=EMCY\r\nDataType=0x7\r\nAccessType=rw\r\nDefaultValue=$NODEID+0x80\r\n"
    "[1400]\r\nParameterName=RPDO\r\nObjectType=9\r\nSubNumber=2\r\n"
    "[1400sub0]\r\nDataType=5\r\nAccessType=ro\r\nDefaultValue=2\r\n"
    "[1400sub1]\r\nDataType=7\r\nAccessType=rw\r\nDefaultValue=0x2C0 + $NodeId\r\n"
    "[1A00]\r\nParameterName=Status\r\nObjectType=9\r\nSubNumber=3\r\n"
    "[1A00sub0]\r\nDataType=5\r\nAccessType=rw\r\nDefaultValue=1\r\n"
    "[1A00sub1]\r\nDataType=7\r\nAccessType=rw\r\nDefaultValue=0x60640020\r\n"
    "[1A00sub2]\r\nDataType=7\r\nAccessType=rw\r\nDefaultValue=0x60410010\r\n"
    "[6064]\r\nParameterName=Position\r\nDataType=4\r\nAccessType=rwr\r\nLowLimit=-1000\r\n"
    "HighLimit=0x7FFFFFFF\r\nDefaultValue=-2\r\nPDOMapping=1\r\n"
    "[ManufacturerObjects]\r\nSupportedObjects=2\r\n1=0x2003\r\n2=0x2100\r\n"
    "[2003]\r\nParameterName=Name\r\nDataType=9\r\nAccessType=rw\r\nDefaultValue=x = 1; y\r\n"
    "[2100]\r\nParameterName=Gain\r\nDataType=8\r\nAccessType=rww\r\nDefaultValue=1.5\r\nPDOMapping=1\r\n";

EdsFile read_sheet(std::string_view text) {
  auto file = read_eds(text, "x.eds");
  EXPECT_TRUE(file) << (file ? "" : describe(file.error()));
  return file.value_or(EdsFile{});
}

const Object& object_of(const EdsFile& file, std::uint16_t index) {
  for (const auto& one : file.device.objects) {
    if (one.index == index) return one;
  }
  ADD_FAILURE() << "there is no object " << index;
  static const Object kNone;
  return kNone;
}

std::vector<std::string> notes_of(const EdsFile& file) {
  std::vector<std::string> texts;
  for (const auto& note : file.notes) texts.push_back(std::to_string(note.line) + ": " + note.text);
  return texts;
}

TEST(EdsRead, IdentityAndBitRates) {
  const auto file = read_sheet(kDrive);
  EXPECT_THAT(notes_of(file), IsEmpty());
  EXPECT_EQ(file.device.vendor_name, "M\xC3\xBCller");
  EXPECT_EQ(file.device.vendor_id, 0x28U);
  EXPECT_EQ(file.device.product_code, 0x1234U);
  EXPECT_EQ(file.device.revision, 15U) << "a leading zero makes it octal";
  EXPECT_EQ(file.device.type, "G392");
  EXPECT_EQ(file.device.name, "Drive 5");
  EXPECT_THAT(file.bit_rates, ElementsAre(125, 1000));
  EXPECT_TRUE(file.lss);
  EXPECT_FALSE(file.place);
}

TEST(EdsRead, ObjectsWithTheirValues) {
  const auto file = read_sheet(kDrive);
  std::vector<unsigned> indices;
  for (const auto& one : file.device.objects) indices.push_back(one.index);
  EXPECT_THAT(indices, ElementsAre(0x1000, 0x1003, 0x1014, 0x1018, 0x1400, 0x1A00, 0x2003, 0x2100, 0x6064));
  EXPECT_EQ(object_of(file, 0x1000).entries.at(0).default_hex, "92010200");
  EXPECT_EQ(object_of(file, 0x1018).code, ObjectCode::kRecord);
  EXPECT_EQ(object_of(file, 0x1018).entries.at(1).name, "Vendor");
  const auto& position = object_of(file, 0x6064).entries.at(0);
  EXPECT_EQ(position.type, DataType::kInteger32);
  EXPECT_EQ(position.default_hex, "FEFFFFFF");
  EXPECT_EQ(position.minimum_hex, "18FCFFFF");
  EXPECT_EQ(position.maximum_hex, "FFFFFF7F");
  EXPECT_TRUE(position.tx_mappable && !position.rx_mappable && position.writable);
  EXPECT_EQ(object_of(file, 0x2100).entries.at(0).default_hex, "0000C03F");
  EXPECT_TRUE(object_of(file, 0x2100).entries.at(0).rx_mappable);
  EXPECT_FALSE(object_of(file, 0x2100).entries.at(0).tx_mappable);
  EXPECT_EQ(object_of(file, 0x2003).entries.at(0).default_hex, "78203D20313B2079");
  EXPECT_EQ(object_of(file, 0x2003).entries.at(0).bit_length, 64);
}

TEST(EdsRead, CompactEntriesHaveNamesAndExceptions) {
  const auto file = read_sheet(kDrive);
  const auto& errors = object_of(file, 0x1003);
  EXPECT_EQ(errors.code, ObjectCode::kArray);
  ASSERT_EQ(errors.entries.size(), 4U);
  EXPECT_EQ(errors.entries[0].default_hex, "03");
  EXPECT_EQ(errors.entries[1].name, "Errors1");
  EXPECT_EQ(errors.entries[2].name, "Older one");
  EXPECT_EQ(errors.entries[2].type, DataType::kUnsigned32);
  EXPECT_FALSE(errors.entries[2].writable);
  EXPECT_EQ(errors.entries[3].name, "Oldest");
  EXPECT_TRUE(errors.entries[3].writable);
}

TEST(EdsRead, FormulasAddTheNodeId) {
  const auto file = read_sheet(kDrive);
  EXPECT_THAT(file.node_id_defaults, ElementsAre(EntryAddress{0x1014, 0}, EntryAddress{0x1400, 1}));
  EXPECT_EQ(file.default_hex({0x1014, 0}, 5), "85000000");
  EXPECT_EQ(file.default_hex({0x1400, 1}, 0x7F), "3F030000");
  EXPECT_EQ(file.default_hex({0x1000, 0}, 5), "92010200");
  EXPECT_EQ(file.default_hex({0x1001, 0}, 5), "");
}

TEST(EdsRead, PdosAreThoseOfTheMappingObjects) {
  const auto file = read_sheet(kDrive);
  EXPECT_THAT(file.device.rx_pdos, IsEmpty());
  ASSERT_EQ(file.device.tx_pdos.size(), 1U);
  const auto& pdo = file.device.tx_pdos[0];
  EXPECT_EQ(pdo.name, "Status");
  EXPECT_FALSE(pdo.fixed);
  ASSERT_EQ(pdo.entries.size(), 1U) << "sub-index 0 says so";
  EXPECT_EQ(pdo.entries[0].index, 0x6064);
  EXPECT_EQ(pdo.entries[0].bit_length, 32);
  EXPECT_EQ(pdo.entries[0].name, "Position");
}

TEST(EdsRead, ADcfHasValuesAndAPlace) {
  const auto file = read_sheet(
      "[DeviceInfo]\nProductName=p\n[DeviceComissioning]\nNodeID=0x11\nNodeName=left\nBaudrate=500\n"
      "[OptionalObjects]\n1=0x1017\n2=0x1014\n"
      "[1014]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x80\nParameterValue=$NODEID + 256\n"
      "[1017]\nDataType=6\nAccessType=rw\nDefaultValue=0\nParameterValue=250\n");
  ASSERT_TRUE(file.place);
  EXPECT_EQ(file.place->node_id, 17);
  EXPECT_EQ(file.place->bit_rate, 500);
  EXPECT_EQ(file.place->name, "left");
  EXPECT_THAT(file.values, ElementsAre(EdsValue{{0x1014, 0}, "00010000", true}, EdsValue{{0x1017, 0}, "FA00", false}));
}

/// What is wrong in a file costs only that part of it, and is named with its line.
// As files of Technosoft, Elmo, Pilz and others have it: the section of the place in correct English with a node-ID of
// 0, formulas with blanks, empty values, no object type, sub-indices in hexadecimal, fewer objects than announced,
// values of compact entries in a section of their own, and configured values in a data sheet.
TEST(EdsRead, VendorsWriteInTheirOwnWays) {
  const auto file = read_sheet(
      "[DeviceInfo]\nProductName=p\nNrOfRxPDO=3\n;LSS_Type=Server\n[Comments]\nLines=0\n"
      "[DeviceCommissioning]\nNodeId=0\nBaudRate=0\n[DummyUsage]\nDummy001B=1\n"
      "[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n"
      "[1000]\nParameterName=Device type\nDenotation=\n;StorageLocation=RAM\nDataType=0x0007\nAccessType=ro\n"
      "DefaultValue=0x60192\nParameterValue=0x60192\n"
      "[ManufacturerObjects]\nSupportedObjects=2\n1=0x2000\n"
      "[2000]\nParameterName=Range\nDataType=0x0004\nAccessType=rww\nDefaultValue=-20000\nPDOMapping=0x1\n"
      "[OptionalObjects]\nSupportedObjects=5\n1=0x1001\n2=0x1014\n3=0x1003\n4=0x1600\n5=0x1028\n"
      "[1001]\nParameterName=Error register\nDataType=0x0005\nAccessType=ro\nDefaultValue=\nParameterValue=\n"
      "[1014]\nParameterName=EMCY\nDataType=0x0007\nAccessType=ro\nDefaultValue=$NODEID +0x80\n"
      "[1003]\nParameterName=Errors\nObjectType=0x8\nSubNumber=0x2\n"
      "[1003sub0]\nDataType=0x0005\nAccessType=rw\nDefaultValue=16\n"
      "[1003sub10]\nParameterName=Oldest\nDataType=0x0007\nAccessType=ro\n"
      "[1600]\nParameterName=RPDO\nObjectType=0x09\nDataType=0x0007\nAccessType=rw\nCompactSubObj=2\n"
      "[1600Value]\nNrOfEntries=2\n1=0x20000110\n2=0x2000020G\n"
      "[1028]\nParameterName=EMCY consumer\nObjectType=0x08\nDataType=0x0007\nAccessType=rw\n"
      "DefaultValue=0x80000000\nCompactSubObj=127\n[1028Value]\nNrOfEntries=1\n3=$NODEID + 0x80\n");
  EXPECT_FALSE(file.place);
  EXPECT_EQ(file.default_hex({0x1014, 0}, 5), "85000000");
  EXPECT_EQ(object_of(file, 0x1003).entries.at(1).subindex, 16);
  EXPECT_EQ(object_of(file, 0x1028).entries.size(), 128U);
  EXPECT_EQ(object_of(file, 0x1001).entries.at(0).default_hex, "");
  const auto& range = object_of(file, 0x2000).entries.at(0);
  EXPECT_EQ(range.default_hex, "E0B1FFFF");
  EXPECT_TRUE(range.rx_mappable && !range.tx_mappable);
  EXPECT_THAT(file.values,
              ElementsAre(EdsValue{{0x1000, 0}, "92010600", false}, EdsValue{{0x1028, 3}, "80000000", true},
                          EdsValue{{0x1600, 1}, "10010020", false}));
  EXPECT_THAT(notes_of(file), ElementsAre(HasSubstr("7: NodeID is missing"),
                                          HasSubstr("\"0x2000020G\", which is no value of its type")));
}

TEST(EdsRead, FaultsInAFileAreNoted) {
  struct Case {
    const char* object;
    const char* note;
  };
  for (const auto& [text, expected] :
       {Case{"DataType=5\nDefaultValue=256\n",
             "6: defaultvalue of 2001h:00 is \"256\", which is no value of its type: it is left out"},
        Case{"DataType=2\nDefaultValue=-129\n",
             "6: defaultvalue of 2001h:00 is \"-129\", which is no value of its type: it is left out"},
        Case{"DataType=6\nLowLimit=ten\n",
             "6: lowlimit of 2001h:00 is \"ten\", which is no value of its type: it is left out"},
        Case{"DataType=7\nDefaultValue=$NODEID*2\n",
             "6: defaultvalue of 2001h:00 is \"$NODEID*2\", which is no value of its type: it is left out"},
        Case{"DataType=8\nDefaultValue=1e300\n",
             "6: defaultvalue of 2001h:00 is \"1e300\", which is no value of its type: it is left out"},
        Case{"DataType=0x16\n", "4: 2001h:00 has the data type 0x0016: it is left out"},
        Case{"DataType=0x0F\nAccessType=ro\n", "4: 2001h:00 has the data type 0x000F: it is read as bytes"},
        Case{"ObjectType=5\nDataType=7\n", "4: 2001h has the object type 5: it is left out"},
        Case{"DataType=7\nPDOMapping=2\n", "6: pdomapping is \"2\", a number up to 1 is expected: it is left out"},
        Case{"ObjectType=9\nSubNumber=4\n[2001sub0]\nDataType=5\n", "4: 2001h announces 4 entries and has 1"},
        Case{"DataType=7\n[2002]\nDataType=7\n", "6: 2002h is in no list of objects: it is added"}}) {
    EXPECT_THAT(notes_of(read_sheet(std::string("[DeviceInfo]\n[ManufacturerObjects]\n1=0x2001\n[2001]\n") + text)),
                ElementsAre(expected))
        << text;
  }
  EXPECT_THAT(
      notes_of(read_sheet("[ManufacturerObjects]\n1=0x2001\n2=x\n3=0x12345\n")),
      ElementsAre("1: there is no [DeviceInfo]: the identity of the device is not known",
                  "2: 2001h has no section: it is left out", "3: \"x\" is no index of an object: it is left out",
                  "4: \"0x12345\" is no index of an object: it is left out"));
  EXPECT_THAT(notes_of(read_sheet("[DeviceInfo]\n[DeviceComissioning]\nNodeID=128\n[OptionalObjects]\n")),
              ElementsAre("2: NodeID is missing, 1 to 127 is expected: the place of the device is left out",
                          "3: nodeid is \"128\", a number up to 127 is expected: it is left out"));
}

TEST(EdsRead, WhatIsNoDataSheetIsRefused) {
  const auto error = [](std::string_view text) {
    const auto file = read_eds(text, "x.eds");
    return file ? std::string("no error") : describe(file.error());
  };
  EXPECT_EQ(error(""),
            "x.eds:1: there is no list of objects: [MandatoryObjects], [OptionalObjects] or [ManufacturerObjects] is "
            "expected in an electronic data sheet");
  EXPECT_EQ(error("[A]\nb=1\nnothing\n"), "x.eds:3: \"nothing\" is neither [section] nor key=value");
  EXPECT_EQ(error("b=1\n"), "x.eds:1: \"b=1\" is neither [section] nor key=value");
  EXPECT_THAT(error("<?xml version=\"1.0\"?>\n"), HasSubstr("x.eds:1: \"<?xml version=\"1.0\"?>\" is neither"));
}

TEST(EdsRead, NotesAreBounded) {
  std::string text = "[DeviceInfo]\n[OptionalObjects]\n";
  for (int i = 0; i < 1000; ++i) text += std::to_string(i) + "=" + std::string(1000, 'x') + "\n";
  const auto file = read_sheet(text);
  EXPECT_EQ(file.notes.size(), 201U);
  EXPECT_LT(file.notes.front().text.size(), 150U);
}

TEST(EdsRead, WhatWasWrittenReadsBackEqual) {
  auto file = read_sheet(kDrive);
  file.place = EdsPlace{5, 250, "left"};
  file.values = {{{0x1014, 0}, "00010000", true}, {{0x2100, 0}, "0000803F", false}};
  const auto again = read_sheet(write_eds(file, "again.dcf"));
  EXPECT_EQ(again.device, file.device);
  EXPECT_EQ(again.node_id_defaults, file.node_id_defaults);
  EXPECT_EQ(again.bit_rates, file.bit_rates);
  EXPECT_EQ(again.lss, file.lss);
  EXPECT_EQ(again.place, file.place);
  EXPECT_EQ(again.values, file.values);
  EXPECT_THAT(again.notes, IsEmpty());
}

}  // namespace
}  // namespace driveline::esi
