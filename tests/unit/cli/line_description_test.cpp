#include "config/line_description.hpp"

#include <gmock/gmock.h>

#include "driveline/cli/line_config.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::cli {
namespace {

using testing::HasSubstr;

SlaveView view_of(std::uint16_t position, std::uint32_t vendor, std::string name) {
  esi::DeviceDescription device;
  device.vendor_id = vendor;
  device.product_code = 0x10 + position;
  device.name = std::move(name);
  SlaveView view;
  view.slave.ref = {position, 0x1001};
  view.sii = esi::make_sii(device);
  return view;
}

TEST(LineDescription, IsAConfigurationThatExpectsWhatWasFound) {
  const std::vector<SlaveView> slaves = {view_of(0, 2, "EK1100"), view_of(1, 0x28, "MSD")};
  const auto text = describe_line(slaves, "eth1");
  ASSERT_TRUE(text);
  const auto config = parse_line_config(*text, "line.toml");
  ASSERT_TRUE(config) << config.error();
  EXPECT_EQ(config->interface, "eth1");
  ASSERT_EQ(config->slaves.size(), 2U);
  EXPECT_EQ(config->slaves[0].vendor_id, 2U);
  EXPECT_EQ(config->slaves[1].vendor_id, 0x28U);
  EXPECT_EQ(config->slaves[1].product_code, 0x11U);
  EXPECT_TRUE(config->axes.empty());
}

TEST(LineDescription, NamesOfSlavesCannotBecomeKeys) {
  const std::vector<SlaveView> slaves = {view_of(0, 2, "a\"\n[[axis]]\nname = \"x\"\\")};
  const auto text = describe_line(slaves, std::nullopt);
  ASSERT_TRUE(text);
  const auto config = parse_line_config(*text, "line.toml");
  ASSERT_TRUE(config) << config.error();
  EXPECT_TRUE(config->axes.empty());
  EXPECT_FALSE(config->interface);
}

TEST(LineDescription, SlaveWithoutIdentityIsNamed) {
  std::vector<SlaveView> slaves = {view_of(0, 2, "EK1100"), view_of(1, 2, "?")};
  slaves[1].sii.reset();
  slaves[1].trouble = "EEPROM: the image ends early";
  const auto text = describe_line(slaves, std::nullopt);
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().text, HasSubstr("slave 1: EEPROM"));
}

}  // namespace
}  // namespace driveline::cli
