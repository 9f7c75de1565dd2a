#include "service/service_manager.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdlib>

namespace driveline::cli {
namespace {

using namespace std::chrono_literals;

/// Listens like a service manager, at an address of the abstract name space.
class ServiceManagerTest : public testing::Test {
 protected:
  ServiceManagerTest() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "driveline-service-test-" + std::to_string(::getpid());
    std::copy(name.begin(), name.end(), address.sun_path + 1);
    const auto bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), bytes), 0);
    ::setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
  }
  ~ServiceManagerTest() override {
    ::close(socket_);
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
  }

  /// The next notification; empty: none.
  std::string told() const {
    std::array<char, 512> text{};
    const auto bytes = ::recv(socket_, text.data(), text.size(), 0);
    return bytes < 0 ? std::string{} : std::string(text.data(), static_cast<std::size_t>(bytes));
  }

 private:
  int socket_;
};

constexpr ServiceManager::Clock::time_point kStart{1000s};

TEST_F(ServiceManagerTest, IsToldOfTheStatesAndTakesItsSettingsAway) {
  ServiceManager manager;
  EXPECT_EQ(std::getenv("NOTIFY_SOCKET"), nullptr) << "programs that are started from here do not speak for this one";
  EXPECT_EQ(told(), "");
  manager.ready("line8 in OP");
  EXPECT_EQ(told(), "READY=1\nSTATUS=line8 in OP\n");
  manager.ending();
  EXPECT_EQ(told(), "STOPPING=1\n");
  EXPECT_FALSE(manager.has_watchdog());
  manager.alive(1, kStart);
  EXPECT_EQ(told(), "") << "nobody asked";
}

TEST_F(ServiceManagerTest, SignsOfLifeNeedCyclesAndHalfTheWatchdogTime) {
  ::setenv("WATCHDOG_USEC", "2000000", 1);
  ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
  ServiceManager manager;
  ASSERT_TRUE(manager.has_watchdog());
  manager.alive(0, kStart);
  EXPECT_EQ(told(), "WATCHDOG=1\n") << "the first one";
  manager.alive(5, kStart + 999ms);
  EXPECT_EQ(told(), "") << "too early";
  manager.alive(0, kStart + 1s);
  EXPECT_EQ(told(), "") << "the line stands still";
  manager.alive(0, kStart + 60s);
  EXPECT_EQ(told(), "");
  manager.alive(1, kStart + 61s);
  EXPECT_EQ(told(), "WATCHDOG=1\n");
  manager.alive(2, kStart + 62s);
  EXPECT_EQ(told(), "WATCHDOG=1\n");
}

TEST_F(ServiceManagerTest, TheWatchdogOfAnotherProcessIsNotOurs) {
  ::setenv("WATCHDOG_USEC", "2000000", 1);
  ::setenv("WATCHDOG_PID", "1", 1);
  EXPECT_FALSE(ServiceManager().has_watchdog());
}

TEST_F(ServiceManagerTest, SettingsThatMakeNoSenseAreNoSettings) {
  for (const char* watchdog : {"", "0", "x", "-5", "99999999999999999999999"}) {
    const std::string address = std::getenv("NOTIFY_SOCKET");
    ::setenv("WATCHDOG_USEC", watchdog, 1);
    EXPECT_FALSE(ServiceManager().has_watchdog()) << watchdog;
    ::setenv("NOTIFY_SOCKET", address.c_str(), 1);
  }
  for (const std::string& address :
       {std::string("@"), std::string("relative"), std::string("/") + std::string(200, 'x')}) {
    ::setenv("NOTIFY_SOCKET", address.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "2000000", 1);
    ServiceManager manager;
    EXPECT_FALSE(manager.has_watchdog()) << address;
    manager.ready("x");
  }
}

TEST(ServiceManagerAway, WhoDoesNotListenIsNoReasonToEnd) {
  ::setenv("NOTIFY_SOCKET", "/nowhere/notify", 1);
  ServiceManager manager;
  manager.ready("x");
  manager.ending();
}

}  // namespace
}  // namespace driveline::cli
