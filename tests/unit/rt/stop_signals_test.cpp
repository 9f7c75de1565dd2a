#include "driveline/rt/stop_signals.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

namespace driveline::rt {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

TEST(StopRequest, SignalsOfABurstAreOneRequest) {
  StopRequest request;
  EXPECT_FALSE(request.requested());
  auto now = nanoseconds{7};
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(request.note(now)) << i;
    EXPECT_TRUE(request.requested());
    now += StopRequest::kPause - nanoseconds{1};
  }
}

TEST(StopRequest, ASignalAfterAPauseDemandsTheEnd) {
  StopRequest request;
  EXPECT_FALSE(request.note(milliseconds{300})) << "the first one, however long the program has run";
  EXPECT_FALSE(request.note(milliseconds{300}));
  EXPECT_FALSE(request.note(milliseconds{400}));
  EXPECT_TRUE(request.note(milliseconds{400} + StopRequest::kPause));
}

TEST(StopRequest, ATimeOfZeroIsATime) {
  StopRequest request;
  EXPECT_FALSE(request.note(nanoseconds{0}));
  EXPECT_TRUE(request.requested());
  EXPECT_TRUE(request.note(StopRequest::kPause));
}

/// Exit status of a process that catches the stop signals and gets one.
[[noreturn]] void get_one(int signal) {
  catch_stop_signals();
  if (stop_requested()) ::_exit(2);
  std::raise(signal);
  ::_exit(stop_requested() ? 0 : 1);
}

TEST(StopSignals, EverySignalThatEndsAProgramIsARequest) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  // All but SIGPROF, which googletest ignores while it makes the process.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU, SIGALRM, SIGVTALRM, SIGIO, SIGPWR,
                           SIGSTKFLT, SIGRTMIN, SIGRTMAX}) {
    EXPECT_EXIT(get_one(signal), testing::ExitedWithCode(0), "") << signal;
  }
}

TEST(StopSignals, ThoseThatAreMeantOtherwiseAreNot) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(get_one(SIGPIPE), testing::ExitedWithCode(1), "") << "ignored";
  EXPECT_EXIT(get_one(SIGCHLD), testing::ExitedWithCode(1), "") << "ignored by default";
  EXPECT_EXIT(get_one(SIGQUIT), testing::KilledBySignal(SIGQUIT), "");
}

TEST(StopSignals, ThatAreIgnoredAlreadyStaySo) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto with_ignored = [] {
    std::signal(SIGHUP, SIG_IGN);  // as nohup does
    get_one(SIGHUP);
  };
  EXPECT_EXIT(with_ignored(), testing::ExitedWithCode(1), "");
}

}  // namespace
}  // namespace driveline::rt
