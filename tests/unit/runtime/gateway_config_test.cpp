// [gateway] of a line description.
#include <gmock/gmock.h>

#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kTwo = "[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n";

auto read(const std::string& gateway) {
  return parse_line_config(kTwo + "[gateway]\n" + gateway, "line.toml");
}

std::string refusal(const std::string& gateway) {
  const auto config = read(gateway);
  return config ? std::string{} : describe(config.error());
}

TEST(GatewayConfig, ListensToThisMachineAloneUnlessItIsTold) {
  const auto config = must(read(""));
  ASSERT_TRUE(config->gateway);
  EXPECT_THAT(config->gateway->settings.address, ElementsAre(127, 0, 0, 1));
  EXPECT_EQ(config->gateway->settings.port, 0x88A4);
  EXPECT_EQ(config->gateway->settings.protocols.size(), 5U);
  EXPECT_THAT(config->gateway->slaves, ElementsAre(0U, 1U));
  EXPECT_FALSE(parse_line_config(kTwo, "line.toml")->gateway);
}

TEST(GatewayConfig, TakesAddressPortProtocolsAndSlaves) {
  const auto config =
      must(read("address = \"192.168.40.1\"\nport = 4000\nprotocols = [\"coe\", \"foe\"]\nslaves = [\"y\"]\n"));
  EXPECT_THAT(config->gateway->settings.address, ElementsAre(192, 168, 40, 1));
  EXPECT_EQ(config->gateway->settings.port, 4000);
  EXPECT_THAT(config->gateway->settings.protocols, ElementsAre(wire::MailboxType::kCoe, wire::MailboxType::kFoe));
  EXPECT_THAT(config->gateway->slaves, ElementsAre(1U));
}

TEST(GatewayConfig, ClientsOnlyReadUnlessUsersOrAddressesMayWrite) {
  const auto usual = must(read(""));
  EXPECT_THAT(usual->gateway->settings.write_users, testing::IsEmpty());
  EXPECT_THAT(usual->gateway->settings.write_addresses, testing::IsEmpty());
  const auto config = must(read("write_users = [\"root\", \"1234\"]\nwrite_addresses = [\"192.168.40.7\"]\n"));
  EXPECT_THAT(config->gateway->settings.write_users, ElementsAre(0U, 1234U));
  EXPECT_THAT(config->gateway->settings.write_addresses, ElementsAre(wire::IpV4Address{192, 168, 40, 7}));
}

TEST(GatewayConfig, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal("write_users = [\"no such user\"]\n"),
              HasSubstr("line.toml:6: [gateway] write_users: there is no user \"no such user\" on this machine"));
  EXPECT_THAT(refusal("write_addresses = [\"tool\"]\n"),
              HasSubstr("write_addresses: is \"tool\", an IPv4 address of a client is expected"));
  EXPECT_THAT(
      refusal("address = \"localhost\"\n"),
      HasSubstr("line.toml:6: [gateway] address: is \"localhost\", an IPv4 address of this machine is expected"));
  EXPECT_THAT(refusal("address = \"::1\"\n"), HasSubstr("an IPv4 address of this machine is expected"));
  EXPECT_THAT(refusal("port = 0\n"), HasSubstr("port"));
  EXPECT_THAT(refusal("port = 65536\n"), HasSubstr("port"));
  EXPECT_THAT(refusal("protocols = [\"eoe\"]\n"), HasSubstr("has \"eoe\", known are \"aoe\", \"coe\", \"foe\""));
  EXPECT_THAT(refusal("slaves = [\"z\"]\n"), HasSubstr("there is no [[slave]] named \"z\""));
  EXPECT_THAT(refusal("adress = \"127.0.0.1\"\n"), HasSubstr("adress: unknown key, expected one of"));
}

}  // namespace
}  // namespace driveline::runtime
