// Support for tests of shared regions: a record with check values, regions of records, and a second process.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <utility>

#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/rt/shared_region.hpp"
#include "driveline/rt/shared_ring.hpp"

namespace driveline::rt::test {

/// Large enough to show a torn copy; only the content from record_of() is intact.
struct Record {
  std::uint64_t number = 0;
  std::array<std::uint64_t, 15> copies{};
};

inline Record record_of(std::uint64_t number) {
  Record record{.number = number};
  std::uint64_t mixed = number;
  for (std::uint64_t& copy : record.copies) {
    mixed = mixed * 6364136223846793005U + 1442695040888963407U;
    copy = mixed;
  }
  return record;
}

inline bool is_intact(const Record& record) {
  return record.copies == record_of(record.number).copies;
}

inline constexpr std::uint32_t kContent = 0xC0FFEE;
inline constexpr std::uint32_t kContentVersion = 3;

inline SharedLayout ring_of_records(std::uint64_t capacity = 0) {
  return shared_ring<Record>(kContent, kContentVersion, capacity);
}
inline SharedLayout broadcast_of_records(std::uint64_t capacity = 0) {
  return shared_broadcast<Record>(kContent, kContentVersion, capacity);
}

inline SharedRegion create(const SharedLayout& layout) {
  auto region = SharedRegion::create("driveline-test", layout);
  if (!region) {
    throw std::runtime_error(describe(region.error()));
  }
  return std::move(*region);
}

inline SharedRegion open(int descriptor, const SharedLayout& wanted) {
  auto region = SharedRegion::open(descriptor, wanted);
  if (!region) {
    throw std::runtime_error(describe(region.error()));
  }
  return std::move(*region);
}

/// Another process that executes `work`; it is running when the constructor returns. Its exit status is the result of
/// `work`, or 99 after an exception.
class Peer {
 public:
  explicit Peer(const std::function<int()>& work) {
    std::array<int, 2> started{};
    if (::pipe2(started.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("pipe2");
    }
    process_ = ::fork();
    if (process_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      [[maybe_unused]] const auto written = ::write(started[1], "", 1);
      try {
        ::_exit(work());
      } catch (...) {
        ::_exit(99);
      }
    }
    ::close(started[1]);
    char ignored = 0;
    [[maybe_unused]] const auto seen = ::read(started[0], &ignored, 1);
    ::close(started[0]);
  }
  ~Peer() {
    if (process_ > 0) {
      end();
    }
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// Stops the process; returns when it has stopped.
  void stop() {
    ::kill(process_, SIGSTOP);
    int status = 0;
    ::waitpid(process_, &status, WUNTRACED);
    EXPECT_TRUE(WIFSTOPPED(status));
  }

  void go_on() { ::kill(process_, SIGCONT); }

  /// Kills the process at any point; returns when it has ended.
  void end() {
    ::kill(process_, SIGKILL);
    wait_for_end();
  }

  /// Waits until the process has ended. Returns its exit status, or the negative number of the signal.
  int wait_for_end() {
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t process_ = -1;
};

}  // namespace driveline::rt::test
