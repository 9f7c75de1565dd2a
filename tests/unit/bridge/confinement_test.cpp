// Capabilities of the bridge after it has dropped all privileges, tried in a child process.
#include "confinement.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <functional>
#include <iterator>
#include <string>
#include <thread>

#include "options.hpp"

namespace driveline::bridge {
namespace {

/// Wait status of a child that drops its privileges, and with `filtered` most system calls, and then executes `work`.
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

/// Exit status of such a child; it must not be ended by a signal.
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

TEST(Confinement, BecomesTheUserThatItIsTold) {
  if (::geteuid() != 0) GTEST_SKIP() << "SKIPPED: only root becomes somebody else";
  const pid_t child = ::fork();
  if (child == 0) {
    if (!give_up_privileges(-1, {1234, 1235}).empty()) ::_exit(90);
    uid_t users[3] = {};
    gid_t groups[3] = {};
    ::getresuid(&users[0], &users[1], &users[2]);
    ::getresgid(&groups[0], &groups[1], &groups[2]);
    const auto all = [](const auto& ids, auto id) { return std::count(std::begin(ids), std::end(ids), id) == 3; };
    ::_exit(all(users, 1234U) && all(groups, 1235U) && ::getgroups(0, nullptr) == 0 ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

/// Exit status of a child that may access shared memory only; 77: the kernel has no Landlock.
int status_with_shared_memory(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (!give_up_privileges(-1).empty()) ::_exit(90);
    if (limit_files_to_shared_memory() == FileLimits::kNone) ::_exit(77);
    if (!filter_system_calls(true).empty()) ::_exit(91);
    ::_exit(work());
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status)) << status;
  return WEXITSTATUS(status);
}

TEST(Confinement, WithSharedMemoryReachesFilesThereAndNoOthers) {
  const auto name = "/dev/shm/driveline-test-" + std::to_string(::getpid());
  const int made = status_with_shared_memory([&] {
    struct stat facts {};
    const int file = ::open(name.c_str(), O_CREAT | O_EXCL | O_RDWR, 0644);
    return file >= 0 && ::ftruncate(file, 4096) == 0 && ::stat(name.c_str(), &facts) == 0 && ::unlink(name.c_str()) == 0
               ? 0
               : 1;
  });
  if (made == 77) GTEST_SKIP() << "SKIPPED: this kernel has no Landlock";
  EXPECT_EQ(made, 0);
  const auto refused = [](const auto& call) {
    return status_with_shared_memory([&] { return call() < 0 && (errno == EACCES || errno == EPERM) ? 0 : 1; });
  };
  EXPECT_EQ(refused([] { return ::open("/etc/passwd", O_RDONLY); }), 0);
  EXPECT_EQ(refused([] { return ::open("/tmp", O_RDONLY | O_DIRECTORY); }), 0);
  EXPECT_EQ(refused([] { return ::open("/tmp/driveline-test", O_CREAT | O_WRONLY, 0600); }), 0);
  EXPECT_EQ(refused([] { return ::open("/proc/self/mem", O_RDWR); }), 0);
  EXPECT_EQ(refused([&] { return ::mkdir(name.c_str(), 0700); }), 0);
  EXPECT_EQ(refused([&] { return ::symlink("/etc/passwd", name.c_str()); }), 0);
  EXPECT_EQ(refused([] { return ::kill(::getppid(), 0); }), 0);
#ifndef DRIVELINE_SANITIZED  // no filter with a sanitizer
  EXPECT_EQ(refused([] { return ::socket(AF_UNIX, SOCK_STREAM, 0); }), 0) << "what is refused without it still is";
#endif
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
  for (const char* const bad : {"", "1000", "0:1000", "1000:0", "1000:1000x", "operator:1000", "4294967295:1"}) {
    const char* const wrong[] = {"--user", bad};
    EXPECT_EQ(read_options(2, wrong).problem,
              "--user needs the numbers of a user and of a group, 1000:1000, and neither is 0")
        << bad;
  }
  const char* const user[] = {"--feed-fd", "4", "--user", "1000:1001"};
  ASSERT_TRUE(read_options(4, user).user);
  EXPECT_EQ(read_options(4, user).user->user, 1000U);
  EXPECT_EQ(read_options(4, user).user->group, 1001U);
  EXPECT_EQ(read_options(0, nullptr).problem, "--process or --feed-fd is missing: set the line to publish");
  const char* const both[] = {"--process", "12", "--return-fd", "7"};
  EXPECT_EQ(read_options(4, both).problem, "--process replaces all inherited descriptors: remove them");
}

}  // namespace
}  // namespace driveline::bridge
