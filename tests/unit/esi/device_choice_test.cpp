#include <gtest/gtest.h>

#include "driveline/esi/esi_file.hpp"

namespace driveline::esi {
namespace {

EsiFile file() {
  EsiFile result;
  const auto add = [&result](const char* type, const char* name, std::uint32_t product, std::uint32_t revision) {
    DeviceDescription device;
    device.type = type;
    device.name = name;
    device.product_code = product;
    device.revision = revision;
    result.devices.push_back(device);
  };
  add("DI8", "DI8 8 inputs", 0x108, 0x10000);
  add("DI8", "DI8 8 inputs", 0x108, 0x20000);
  add("DO4", "DO4 4 outputs", 0x204, 0x10000);
  return result;
}

std::string reason(const EsiFile& from, const DeviceChoice& choice) {
  const auto chosen = from.choose(choice);
  return chosen ? "chosen" : describe(chosen.error());
}

TEST(DeviceChoice, ByTypeNameProductOrRevision) {
  const EsiFile all = file();
  EXPECT_EQ(all.choose({"do4", {}, {}}), &all.devices[2]);
  EXPECT_EQ(all.choose({"DO4 4 Outputs", {}, {}}), &all.devices[2]);
  EXPECT_EQ(all.choose({"", 0x204, {}}), &all.devices[2]);
  EXPECT_EQ(all.choose({"", 0x108, 0x10000}), &all.devices[0]);
  EXPECT_EQ(all.choose({"", {}, 0x20000}), &all.devices[1]);
}

TEST(DeviceChoice, TheHighestRevisionWhenNoneIsAskedFor) {
  const EsiFile all = file();
  EXPECT_EQ(all.choose({"DI8", {}, {}}), &all.devices[1]);
}

TEST(DeviceChoice, TheOnlyDeviceNeedsNoChoice) {
  EsiFile one = file();
  one.devices.erase(one.devices.begin(), one.devices.begin() + 2);
  EXPECT_EQ(one.choose({}), &one.devices[0]);
}

TEST(DeviceChoice, SaysWhatIsThere) {
  const EsiFile all = file();
  EXPECT_EQ(reason(all, {"AI2", {}, {}}),
            "there is no device \"AI2\", but \"DI8\" (0x00000108, revision 0x00010000, 0x00020000), \"DO4\" "
            "(0x00000204, revision 0x00010000)");
  EXPECT_EQ(reason(all, {"DO4", 0x108, 3}),
            "there is no device \"DO4\" with product code 0x00000108 of revision 0x00000003, but \"DI8\" (0x00000108, "
            "revision 0x00010000, 0x00020000), \"DO4\" (0x00000204, revision 0x00010000)");
  EXPECT_EQ(reason(all, {"", {}, 0x10000}),
            "the file has several devices of revision 0x00010000; choose one by type, name or product code: \"DI8\" "
            "(0x00000108, revision 0x00010000), \"DO4\" (0x00000204, revision 0x00010000)");
  EXPECT_EQ(reason({}, {}), "the file describes no device");
}

}  // namespace
}  // namespace driveline::esi
