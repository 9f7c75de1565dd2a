#include "driveline/port/interface_lock.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace driveline::port {
namespace {

// Each of its own: they may run at the same time.

TEST(InterfaceLock, IsTakenOnceAndNamesItsHolder) {
  constexpr const char* kInterface = "lo";  // the one that there is everywhere
  auto first = InterfaceLock::take(kInterface);
  ASSERT_TRUE(first);
  const auto second = InterfaceLock::take(kInterface);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().pid, getpid());
  EXPECT_THAT(second.error().command, testing::HasSubstr("test"));
  const auto holder = InterfaceLock::holder(kInterface);
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->pid, getpid());
  EXPECT_TRUE(InterfaceLock::take("another")) << "each interface has its own";
}

TEST(InterfaceLock, IsFreeWhenItsOwnerIsGone) {
  constexpr const char* kInterface = "nowhere1";
  { EXPECT_TRUE(InterfaceLock::take(kInterface)); }
  EXPECT_FALSE(InterfaceLock::holder(kInterface));
  EXPECT_TRUE(InterfaceLock::take(kInterface));
}

TEST(InterfaceLock, OfAProcessThatWasKilledIsFree) {
  constexpr const char* kInterface = "nowhere2";
  int ready[2] = {-1, -1};
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = InterfaceLock::take(kInterface);
    const char taken = lock ? 'y' : 'n';
    if (write(ready[1], &taken, 1) == 1) pause();
    _exit(0);
  }
  char taken = 0;
  ASSERT_EQ(read(ready[0], &taken, 1), 1);
  EXPECT_EQ(taken, 'y');
  const auto refused = InterfaceLock::take(kInterface);
  EXPECT_EQ(refused ? 0 : refused.error().pid, child);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
  EXPECT_TRUE(InterfaceLock::take(kInterface));
}

}  // namespace
}  // namespace driveline::port
