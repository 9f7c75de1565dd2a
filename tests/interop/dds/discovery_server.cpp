// A discovery server of Fast DDS, number 0, like that of the original tool, which Debian does not package.
//
//   discovery_server <address> <port>
//
// Prints "listens" on stdout; SIGTERM ends it.
#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <istream>
#include <memory>
#include <sstream>
#include <string>

int main(int argc, char** argv) {
  namespace dds = eprosima::fastdds::dds;
  namespace rtps = eprosima::fastrtps::rtps;
  if (argc != 3) {
    std::fputs("usage: discovery_server <address> <port>\n", stderr);
    return 2;
  }
  dds::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = {argv[1]};
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  std::istringstream{eprosima::fastdds::rtps::DEFAULT_ROS2_SERVER_GUIDPREFIX} >> qos.wire_protocol().prefix;
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  rtps::IPLocator::setIPv4(locator, argv[1]);
  rtps::IPLocator::setPhysicalPort(locator, static_cast<std::uint16_t>(std::atoi(argv[2])));
  auto& builtin = qos.wire_protocol().builtin;
  builtin.discovery_config.discoveryProtocol = rtps::DiscoveryProtocol_t::SERVER;
  builtin.metatrafficUnicastLocatorList.push_back(locator);
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  sigprocmask(SIG_BLOCK, &end, nullptr);
  auto* const factory = dds::DomainParticipantFactory::get_instance();
  auto* const server = factory->create_participant(0, qos);
  if (server == nullptr) return 1;
  std::puts("listens");
  std::fflush(stdout);
  int number = 0;
  sigwait(&end, &number);
  factory->delete_participant(server);
  return 0;
}
