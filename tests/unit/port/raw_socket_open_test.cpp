#include <gmock/gmock.h>

#include "driveline/port/raw_socket_port.hpp"

namespace driveline::port {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

PortError error_of_opening(const std::string& interface) {
  const rt::MonotonicClock clock;
  const auto port = RawSocketPort::open({.interface = interface}, clock);
  return port ? PortError{} : port.error();
}

TEST(RawSocketOpen, UnknownInterfaceIsNamedAndOthersAreOffered) {
  const PortError error = error_of_opening("nosuchif0");
  EXPECT_EQ(error.code, PortErrorCode::kNoSuchInterface);
  // The suggested interfaces depend on the machine; loopback is never suggested, because it would be refused next.
  EXPECT_THAT(error.message, AllOf(StartsWith("There is no interface 'nosuchif0'; "), EndsWith("."),
                                   Not(HasSubstr(" lo.")), Not(HasSubstr(" lo,"))));
}

TEST(RawSocketOpen, LoopbackIsRefusedWithAWayOut) {
  const PortError error = error_of_opening("lo");
  EXPECT_EQ(error.code, PortErrorCode::kNotEthernet);
  EXPECT_EQ(error.message,
            "Interface 'lo' is the loopback interface, which no EtherCAT slave can be connected to; name an Ethernet "
            "interface or one end of a veth pair.");
}

TEST(RawSocketOpen, NamesThatCannotBeInterfacesAreRefused) {
  for (const std::string& name :
       {std::string{}, std::string(16, 'x'), std::string(4000, 'x'), std::string{"l\0o", 3}}) {
    const PortError error = error_of_opening(name);
    EXPECT_EQ(error.code, PortErrorCode::kInvalidName) << name.size();
    EXPECT_THAT(error.message, HasSubstr("Linux allows 1 to 15 characters"));
  }
}

TEST(RawSocketOpen, LongestNameIsLookedUpWhole) {
  const std::string name(15, 'x');
  const PortError error = error_of_opening(name);
  EXPECT_EQ(error.code, PortErrorCode::kNoSuchInterface);
  EXPECT_THAT(error.message, HasSubstr("'" + name + "'"));
}

}  // namespace
}  // namespace driveline::port
