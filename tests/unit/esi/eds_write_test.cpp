// Electronic data sheets: sections and keys as in CiA 306-1.
#include "driveline/esi/eds_file.hpp"

#include <gtest/gtest.h>

namespace driveline::esi {
namespace {

ObjectEntry entry(std::uint8_t subindex, std::string name, DataType type, std::string value) {
  ObjectEntry result;
  result.subindex = subindex;
  result.name = std::move(name);
  result.type = type;
  result.default_hex = std::move(value);
  return result;
}

DeviceDescription small_device() {
  DeviceDescription device;
  device.vendor_id = 0x28;
  device.product_code = 0x1234;
  device.vendor_name = "Moog";
  device.name = "Drive";
  device.type = "G392";
  device.rx_pdos.resize(4);
  auto alias = entry(0, "Alias", DataType::kVisibleString, {});
  alias.writable = true;
  auto speed = entry(1, "Switch", DataType::kUnsigned32, "00005000");
  speed.minimum_hex = "01000000";
  speed.writable = speed.rx_mappable = true;
  device.objects = {
      {0x1000, "Device type", ObjectCode::kVariable, {entry(0, "Device type", DataType::kUnsigned32, "92010200")}},
      {0x2003, "Alias", ObjectCode::kVariable, {alias}},
      {0x6099,
       "Homing speeds",
       ObjectCode::kArray,
       {entry(0, "Number of entries", DataType::kUnsigned8, "02"), speed}}};
  return device;
}

TEST(EdsWrite, SectionsAndKeysAreThoseOfCia306) {
  EXPECT_EQ(write_eds(small_device(), "drive.eds"),
            "[FileInfo]\nFileName=drive.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription=Drive\n"
            "\n[DeviceInfo]\nVendorName=Moog\nVendorNumber=0x00000028\nProductName=Drive\nProductNumber=0x00001234\n"
            "RevisionNumber=0x00000000\nOrderCode=G392\nNrOfRXPDO=4\nNrOfTXPDO=0\nDynamicChannelsSupported=0\n"
            "LSS_Supported=0\n"
            "\n[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n"
            "\n[1000]\nParameterName=Device type\nObjectType=0x7\nDataType=0x0007\nAccessType=ro\n"
            "DefaultValue=0x00020192\nPDOMapping=0\n"
            "\n[OptionalObjects]\nSupportedObjects=1\n1=0x6099\n"
            "\n[6099]\nParameterName=Homing speeds\nObjectType=0x8\nSubNumber=2\n"
            "\n[6099sub0]\nParameterName=Number of entries\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\n"
            "DefaultValue=0x02\nPDOMapping=0\n"
            "\n[6099sub1]\nParameterName=Switch\nObjectType=0x7\nDataType=0x0007\nAccessType=rww\n"
            "LowLimit=0x00000001\nDefaultValue=0x00500000\nPDOMapping=1\n"
            "\n[ManufacturerObjects]\nSupportedObjects=1\n1=0x2003\n"
            "\n[2003]\nParameterName=Alias\nObjectType=0x7\nDataType=0x0009\nAccessType=rw\nPDOMapping=0\n");
}

}  // namespace
}  // namespace driveline::esi
