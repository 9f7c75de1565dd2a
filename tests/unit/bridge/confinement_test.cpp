// What the bridge can do when it has given up everything, tried in a child.
#include "confinement.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <functional>
#include <string>
#include <thread>

#include "options.hpp"

namespace driveline::bridge {
namespace {

/// Wait status of a child that has given up its privileges, and with `filtered` most system calls, and then does
/// `work`.
int confined(bool filtered, const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (!give_up_privileges(-1).empty()) ::_exit(90);
    if (filtered && !filter_system_calls().empty()) ::_exit(91);
    ::_exit(work());
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return status;
}

/// Its exit status; it must have ended by itself.
int status_of(bool filtered, const std::function<int()>& work) {
  const int status = confined(filtered, work);
  EXPECT_TRUE(WIFEXITED(status)) << status;
  return WEXITSTATUS(status);
}

TEST(Confinement, LeavesNoPrivilege) {
  EXPECT_EQ(status_of(false,
                      [] {
                        uid_t real = 0;
                        uid_t effective = 0;
                        uid_t saved = 0;
                        ::getresuid(&real, &effective, &saved);
                        return real != 0 && effective != 0 && saved != 0 ? 0 : 1;
                      }),
            0)
      << "it is still root";
  EXPECT_EQ(status_of(false, [] { return ::getgroups(0, nullptr); }), ::geteuid() == 0 ? 0 : ::getgroups(0, nullptr));
  EXPECT_EQ(status_of(false, [] { return ::prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0); }), 1);
  EXPECT_EQ(status_of(false, [] { return ::socket(AF_PACKET, SOCK_RAW, 0) < 0 && errno == EPERM ? 0 : 1; }), 0);
  EXPECT_EQ(status_of(false, [] { return ::setuid(0) == 0 ? 1 : 0; }), 0);
  EXPECT_EQ(status_of(false, [] { return ::sched_getscheduler(0); }), SCHED_OTHER);
}

TEST(Confinement, LimitsItsMemory) {
#ifdef DRIVELINE_SANITIZED
  GTEST_SKIP() << "SKIPPED: not with the memory of a sanitizer";
#endif
  const auto mapped = [](std::size_t mebibytes) {
    return ::mmap(nullptr, mebibytes << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
  };
  EXPECT_EQ(status_of(false, [&] { return mapped(128) ? 0 : 1; }), 0);
  EXPECT_EQ(status_of(false, [&] { return mapped(257) ? 1 : 0; }), 0);
}

TEST(Confinement, RefusesFilesProcessesAndOtherSockets) {
#ifdef DRIVELINE_SANITIZED
  GTEST_SKIP() << "SKIPPED: no filter with a sanitizer";
#endif
  const auto refused = [](const auto& call) {
    return status_of(true, [&] { return call() < 0 && errno == EPERM ? 0 : 1; });
  };
  EXPECT_EQ(refused([] { return ::open("/etc/passwd", O_RDONLY); }), 0);
  EXPECT_EQ(refused([] { return ::open("/dev/null", O_WRONLY); }), 0);
  EXPECT_EQ(refused([] { return ::socket(AF_PACKET, SOCK_DGRAM, 0); }), 0);
  EXPECT_EQ(refused([] { return ::socket(AF_UNIX, SOCK_STREAM, 0); }), 0);
  EXPECT_EQ(refused([] { return ::kill(::getppid(), 0); }), 0);
  EXPECT_EQ(refused([] { return static_cast<int>(::syscall(SYS_tgkill, ::getppid(), ::getppid(), 0)); }), 0);
  EXPECT_EQ(refused([] { return ::ioctl(STDIN_FILENO, TIOCSTI, "x"); }), 0);
  EXPECT_EQ(refused([] { return ::unlink("/tmp/nothing"); }), 0);
  EXPECT_EQ(refused([] { return static_cast<int>(::syscall(SYS_clone, SIGCHLD, nullptr, nullptr, nullptr, nullptr)); }),
            0);
  EXPECT_EQ(refused([] {
              const auto code = PROT_READ | PROT_EXEC;
              return ::mmap(nullptr, 4096, code, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? -1 : 0;
            }),
            0);
}

TEST(Confinement, EndsWhoeverStartsAProgramOrLooksIntoAnother) {
#ifdef DRIVELINE_SANITIZED
  GTEST_SKIP() << "SKIPPED: no filter with a sanitizer";
#endif
  const auto fatal = [](const std::function<void()>& call) {
    const int status = confined(true, [&] {
      call();
      return 0;
    });
    return WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS;
  };
  EXPECT_TRUE(fatal([] { ::execl("/bin/true", "true", nullptr); }));
  EXPECT_TRUE(fatal([] { ::syscall(SYS_ptrace, 0, 0, 0, 0); }));
  EXPECT_TRUE(fatal([] { ::syscall(SYS_process_vm_readv, ::getppid(), nullptr, 0, nullptr, 0, 0); }));
}

TEST(Confinement, LetsItWork) {
  EXPECT_EQ(status_of(true, [] { return ::socket(AF_INET, SOCK_DGRAM, 0) < 0 ? 1 : 0; }), 0);
  EXPECT_EQ(status_of(true,
                      [] {
                        int answer = 1;
                        std::thread{[&] { answer = 0; }}.join();
                        return answer;
                      }),
            0)
      << "Fast DDS starts a thread with its first message";
  const int status = confined(true, []() -> int { std::abort(); });
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT) << "an assertion ends it as one";
}

TEST(Confinement, KeepsOffTheProcessorOfTheCycleWhereThereIsAnother) {
  cpu_set_t before;
  ASSERT_EQ(::sched_getaffinity(0, sizeof(before), &before), 0);
  int first = 0;
  while (!CPU_ISSET(static_cast<std::size_t>(first), &before)) ++first;
  const bool another = CPU_COUNT(&before) > 1;
  const pid_t child = ::fork();
  if (child == 0) {
    cpu_set_t after;
    const bool given_up = give_up_privileges(first).empty() && ::sched_getaffinity(0, sizeof(after), &after) == 0;
    ::_exit(!given_up ? 2 : CPU_ISSET(static_cast<std::size_t>(first), &after) ? 1 : 0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), another ? 0 : 1);
}

TEST(BridgeOptions, AreDescriptors) {
  const char* const line[] = {"--supervisor-fd", "3", "--feed-fd", "4", "--return-fd", "7", "--condition-fd", "9"};
  const auto options = read_options(8, line);
  EXPECT_EQ(options.problem, "");
  EXPECT_EQ(options.supervisor, 3);
  EXPECT_EQ(options.feed, 4);
  EXPECT_EQ(options.counts, 7);
  EXPECT_EQ(options.condition, 9);
  for (const char* const bad : {"", "-1", "4x", "99999999999"}) {
    const char* const wrong[] = {"--feed-fd", bad};
    EXPECT_EQ(read_options(2, wrong).problem, "--feed-fd needs the number of a descriptor") << bad;
  }
  EXPECT_EQ(read_options(0, nullptr).problem, "--process or --feed-fd is missing: what is to be published?");
  const char* const both[] = {"--process", "12", "--return-fd", "7"};
  EXPECT_EQ(read_options(4, both).problem,
            "--process stands for all descriptors of the line: leave out those that are inherited");
}

}  // namespace
}  // namespace driveline::bridge
