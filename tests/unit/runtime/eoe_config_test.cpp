// [eoe] and the `ip` of the slaves, from the file to the printed routes.
#include <gmock/gmock.h>

#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string slave(const std::string& name, const std::string& ip) {
  return "[[slave]]\nname = \"" + name + "\"\n" + (ip.empty() ? "" : "ip = \"" + ip + "\"\n");
}
const std::string kTwo = slave("x", "192.168.38.5") + slave("y", "192.168.38.6");
const std::string kEoe = "[eoe]\ninterface = \"dl-eoe\"\n";

std::string refusal(const std::string& text) {
  const auto config = parse_line_config(text, "line.toml");
  return config ? std::string{} : describe(config.error());
}

TEST(EoeConfig, HasTheAddressesOfTheManual) {
  const auto config = must(parse_line_config(kTwo + kEoe + "address = \"192.168.38.1/24\"\n", "line.toml"));
  ASSERT_TRUE(config->eoe);
  EXPECT_EQ(config->eoe->interface, "dl-eoe");
  EXPECT_EQ(to_text(config->eoe->address), "192.168.38.1/24");
  EXPECT_EQ(to_text(config->eoe->gateway), "192.168.38.1");
  EXPECT_EQ(to_text(*config->slaves[1].ip), "192.168.38.6");
  EXPECT_TRUE(route_commands(*config->eoe).empty());
}

TEST(EoeConfig, TellsTheRoutesOfAServicePc) {
  const auto config = must(parse_line_config(
      kTwo + kEoe + "address = \"192.168.38.1/24\"\nservice_address = \"192.168.40.1/24\"\n", "line.toml"));
  EXPECT_THAT(
      route_commands(*config->eoe),
      ElementsAre(HasSubstr("net.ipv4.ip_forward=1"), HasSubstr("ip route add 192.168.38.0/24 via 192.168.40.1"),
                  HasSubstr("route add 192.168.38.0 mask 255.255.255.0 192.168.40.1")));
}

TEST(EoeConfig, WithoutItThereIsNone) {
  const auto config = must(parse_line_config(slave("x", ""), "line.toml"));
  EXPECT_FALSE(config->eoe);
  EXPECT_THAT(refusal(kTwo), HasSubstr("a [[slave]] has an ip, but there is no [eoe]"));
}

TEST(EoeConfig, RefusesAddressesThatCannotWork) {
  const auto with = [](const std::string& rest) { return refusal(kTwo + kEoe + rest); };
  EXPECT_THAT(with(""), HasSubstr("[eoe] address"));
  EXPECT_THAT(with("address = \"192.168.38.1\"\n"), HasSubstr("is \"192.168.38.1\", an IPv4 address with the bits"));
  EXPECT_THAT(with("address = \"192.168.38.1/31\"\n"), HasSubstr("\"192.168.38.1/24\", is expected"));
  EXPECT_THAT(with("address = \"192.168.38.256/24\"\n"), HasSubstr("is expected"));
  EXPECT_THAT(with("address = \"192.168.38.1/24x\"\n"), HasSubstr("is expected"));
  EXPECT_THAT(with("address = \"192.168.38.0/24\"\n"), HasSubstr("the network itself or its broadcast"));
  EXPECT_THAT(with("address = \"192.168.38.255/24\"\n"), HasSubstr("the network itself or its broadcast"));
  EXPECT_THAT(with("address = \"192.168.39.1/24\"\n"),
              HasSubstr("192.168.39.0/24 is the network of the drives' service"));
  EXPECT_THAT(with("address = \"192.168.1.1/16\"\n"),
              HasSubstr("192.168.39.0/24 is the network of the drives' service"));
  EXPECT_THAT(with("address = \"192.168.37.1/24\"\n"), HasSubstr("\"x\" has 192.168.38.5: all slaves must be"));
  EXPECT_THAT(with("address = \"192.168.38.5/24\"\n"),
              HasSubstr("\"x\" has 192.168.38.5, which is the address of this"));
  EXPECT_THAT(with("address = \"192.168.38.1/24\"\ngateway = \"192.168.38.6\"\n"), HasSubstr("\"y\" has 192.168.38.6"));
  EXPECT_THAT(with("address = \"192.168.38.1/24\"\ngateway = \"192.168.37.1\"\n"), HasSubstr("which is no host of"));
  EXPECT_THAT(with("address = \"192.168.38.1/24\"\nservice_address = \"192.168.38.77/28\"\n"),
              HasSubstr("in the network of the slaves"));
  EXPECT_THAT(with("address = \"192.168.38.1/24\"\nmtu = 9000\n"), HasSubstr("mtu"));
  EXPECT_THAT(refusal(kTwo + "[eoe]\ninterface = \"\"\naddress = \"192.168.38.1/24\"\n"),
              HasSubstr("interface: is empty"));
}

TEST(EoeConfig, RefusesSlavesThatCannotBeTold) {
  const auto eoe = kEoe + "address = \"192.168.38.1/24\"\n";
  EXPECT_THAT(refusal(slave("x", "192.168.38.5") + slave("y", "192.168.38.5") + eoe),
              HasSubstr("ip: \"x\" has 192.168.38.5 already"));
  EXPECT_THAT(refusal(slave("x", "192.168.38.255") + eoe), HasSubstr("all slaves must be in this network"));
  EXPECT_THAT(refusal(slave("x", "192.168.38") + eoe), HasSubstr("is \"192.168.38\", an IPv4 address"));
  EXPECT_THAT(refusal(slave("x", "") + eoe), HasSubstr("no [[slave]] has an ip"));
}

TEST(IpNetwork, KnowsItsHosts) {
  const auto network = must(parse_network("10.1.2.3/30"));
  EXPECT_EQ(to_text(network->base()), "10.1.2.0");
  EXPECT_EQ(to_text(network->mask()), "255.255.255.252");
  EXPECT_TRUE(network->is_host({10, 1, 2, 1}));
  EXPECT_TRUE(network->is_host({10, 1, 2, 2}));
  EXPECT_FALSE(network->is_host({10, 1, 2, 0}));
  EXPECT_FALSE(network->is_host({10, 1, 2, 3}));
  EXPECT_FALSE(network->is_host({10, 1, 2, 4}));
}

}  // namespace
}  // namespace driveline::runtime
