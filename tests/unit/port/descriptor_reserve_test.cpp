#include "driveline/port/descriptor_reserve.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <string>
#include <vector>

namespace driveline::port {
namespace {

/// A listening socket with clients that wait at it, in a process that can run out of file descriptors.
class Exhausted : public testing::Test {
 protected:
  void SetUp() override {
    // An abstract name that the kernel chooses (unix(7)).
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    listener = rt::FileDescriptor{::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0)};
    ASSERT_EQ(::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address.sun_family), 0);
    socklen_t size = sizeof address;
    ASSERT_EQ(::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    ASSERT_EQ(::listen(listener.get(), 4), 0);
    for (auto& client : clients) {
      client = rt::FileDescriptor{::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0)};
      ASSERT_EQ(::connect(client.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    }
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  }
  void TearDown() override { ::setrlimit(RLIMIT_NOFILE, &before); }

  /// Leaves no descriptor free.
  void exhaust() {
    auto fewer = before;
    fewer.rlim_cur = 64;
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &fewer), 0);
    for (rt::FileDescriptor one{::open("/dev/null", O_RDONLY)}; one.valid();
         one = rt::FileDescriptor{::open("/dev/null", O_RDONLY)}) {
      taken.push_back(std::move(one));
    }
    ASSERT_EQ(errno, EMFILE);
  }
  [[nodiscard]] bool accepts() const { return rt::FileDescriptor{::accept(listener.get(), nullptr, nullptr)}.valid(); }
  /// What the client was sent until the connection was closed; "open" at the end if it is not closed.
  static std::string heard(const rt::FileDescriptor& client) {
    std::array<char, 64> buffer{};
    std::string text;
    ssize_t count = 0;
    while ((count = ::recv(client.get(), buffer.data(), buffer.size(), 0)) > 0) {
      text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return count == 0 ? text : text + "open";
  }

  rt::FileDescriptor listener;
  std::array<rt::FileDescriptor, 2> clients;
  std::vector<rt::FileDescriptor> taken;
  rlimit before{};
};

TEST_F(Exhausted, OneClientAfterTheOtherIsTurnedAway) {
  DescriptorReserve reserve;
  exhaust();
  ASSERT_FALSE(accepts());
  EXPECT_TRUE(reserve.turn_away(listener.get(), "full\n"));
  EXPECT_EQ(heard(clients[0]), "full\n");
  EXPECT_EQ(heard(clients[1]), "open");
  ASSERT_FALSE(accepts());
  EXPECT_TRUE(reserve.turn_away(listener.get()));
  EXPECT_EQ(heard(clients[1]), "");
  // No client waits any more, and Linux still reports the lack of descriptors first.
  ASSERT_FALSE(accepts());
  EXPECT_TRUE(reserve.turn_away(listener.get()));
}

TEST_F(Exhausted, ItTellsWhenTheReservedOneIsGone) {
  exhaust();
  DescriptorReserve reserve;
  ASSERT_FALSE(accepts());
  EXPECT_FALSE(reserve.turn_away(listener.get()));
  EXPECT_EQ(heard(clients[0]), "open");
  taken.pop_back();
  ASSERT_TRUE(accepts()) << "the first client";
  errno = EMFILE;
  EXPECT_TRUE(reserve.turn_away(listener.get())) << "there is one again";
  EXPECT_EQ(heard(clients[1]), "");
}

TEST_F(Exhausted, OtherErrorsTurnNobodyAway) {
  DescriptorReserve reserve;
  errno = EAGAIN;
  EXPECT_TRUE(reserve.turn_away(listener.get(), "full\n"));
  EXPECT_EQ(heard(clients[0]), "open");
}

}  // namespace
}  // namespace driveline::port
