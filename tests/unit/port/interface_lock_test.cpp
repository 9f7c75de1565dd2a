#include "driveline/port/interface_lock.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/must.hpp"

namespace driveline::port {
namespace {

// Each test uses a name of its own, because they may run at the same time.

TEST(InterfaceLock, IsTakenOnceAndNamesItsHolder) {
  constexpr const char* kInterface = "lo";  // exists on every machine
  auto first = must(InterfaceLock::take(kInterface));
  const auto second = InterfaceLock::take(kInterface);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().pid, getpid());
  EXPECT_THAT(second.error().command, testing::HasSubstr("test"));
  const auto holder = must(InterfaceLock::holder(kInterface));
  EXPECT_EQ(holder->pid, getpid());
  EXPECT_TRUE(InterfaceLock::take("another")) << "each interface has its own";
}

TEST(InterfaceLock, IsFreeWhenItsOwnerIsGone) {
  constexpr const char* kInterface = "nowhere1";
  { EXPECT_TRUE(InterfaceLock::take(kInterface)); }
  EXPECT_FALSE(InterfaceLock::holder(kInterface));
  EXPECT_TRUE(InterfaceLock::take(kInterface));
}

/// "eth1" and "eth11": the lock of the longer name is not that of the shorter one.
TEST(InterfaceLock, OfANameThatBeginsAlikeIsAnother) {
  const auto longer = must(InterfaceLock::take("nowhere33"));
  EXPECT_FALSE(InterfaceLock::holder("nowhere3"));
  int done[2] = {-1, -1};
  int ready[2] = {-1, -1};
  ASSERT_EQ(pipe(done), 0);
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto shorter = InterfaceLock::take("nowhere3");
    char byte = shorter ? 'y' : 'n';
    if (write(ready[1], &byte, 1) == 1 && read(done[0], &byte, 1) == 1) _exit(0);
    _exit(1);
  }
  char taken = 0;
  ASSERT_EQ(read(ready[0], &taken, 1), 1);
  EXPECT_EQ(taken, 'y');
  const auto holder = InterfaceLock::holder("nowhere3");
  EXPECT_EQ(holder ? holder->pid : 0, child);
  EXPECT_EQ(write(done[1], &taken, 1), 1);
  waitpid(child, nullptr, 0);
  for (const int end : {done[0], done[1], ready[0], ready[1]}) close(end);
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
