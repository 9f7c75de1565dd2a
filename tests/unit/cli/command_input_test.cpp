// Commands of clients at the socket that may be slow, silent, or disconnected.
#include "commands/command_input.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <thread>
#include <vector>

#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using std::chrono::milliseconds;

class CommandSocket : public test::TemporaryDirectory, public CommandExecutor {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    path = (directory / "line.socket").string();
    auto opened = must(CommandInput::open(path, CommandInput::Sources::kSocket));
    input = std::move(*opened);
  }

  [[nodiscard]] rt::FileDescriptor connect() const {
    rt::FileDescriptor socket{::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0)};
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    EXPECT_EQ(::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    return socket;
  }
  static void say(const rt::FileDescriptor& socket, std::string_view text) {
    EXPECT_EQ(::send(socket.get(), text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  /// Everything received so far.
  static std::string heard(const rt::FileDescriptor& socket) {
    std::string text;
    std::array<char, 65536> buffer;
    for (auto count = ::recv(socket.get(), buffer.data(), buffer.size(), 0); count > 0;
         count = ::recv(socket.get(), buffer.data(), buffer.size(), 0)) {
      text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return text;
  }
  /// Polls once, as the program does every few milliseconds.
  void look() { input->run(milliseconds{0}, *this); }
  CommandReply execute(const CommandSender& sender, std::string_view command) override {
    executed.emplace_back(command);
    EXPECT_EQ(sender.process, getpid());
    EXPECT_EQ(sender.user, geteuid());
    return {answer.empty() ? std::string(command) + "!" : answer, command.starts_with("stay"), command == "later"};
  }
  void disconnected(const CommandSender& sender) override { left.push_back(sender.connection); }

  std::string path;
  std::unique_ptr<CommandInput> input;
  std::vector<std::string> executed;
  std::string answer;
  std::vector<std::uint64_t> left;
};

TEST_F(CommandSocket, AClientForWhichNoDescriptorIsLeftIsToldSo) {
  const auto client = connect();
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  auto fewer = before;
  fewer.rlim_cur = 64;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &fewer), 0);
  std::vector<rt::FileDescriptor> taken;
  do {
    taken.emplace_back(::open("/dev/null", O_RDONLY));
  } while (taken.back().valid());
  look();
  const auto told = heard(client);
  taken.clear();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(told, "error: no file descriptor is left for another client (ulimit -n)\n");
  const auto next = connect();
  say(next, "1\n");
  look();
  EXPECT_EQ(heard(next), "1!\n");
}

TEST_F(CommandSocket, WhatAServerSaysBeforeItClosesIsHeard) {
  input.reset();
  rt::FileDescriptor listener{::socket(AF_UNIX, SOCK_STREAM, 0)};
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  ASSERT_EQ(::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(listener.get(), 1), 0);
  auto connection = must(CommandConnection::open(path, "run"));
  say(rt::FileDescriptor{::accept(listener.get(), nullptr, nullptr)}, "error: full\n");
  const auto last_words = must(connection->ask("status"));
  EXPECT_EQ(*last_words, "error: full");
}

TEST_F(CommandSocket, WhoStaysIsAnsweredAgainAndMissedWhenHeGoes) {
  {
    const auto client = connect();
    say(client, "stay 1\nstay 2\n");
    look();
    EXPECT_EQ(heard(client), "stay 1!\nstay 2!\n") << "also what came at once";
    say(client, "stay 3\n");
    look();
    EXPECT_EQ(heard(client), "stay 3!\n");
    EXPECT_THAT(left, testing::IsEmpty());
  }
  look();
  EXPECT_THAT(left, testing::ElementsAre(1U));
  {
    const auto client = connect();
    say(client, "diag\n");
  }
  look();
  EXPECT_THAT(left, testing::ElementsAre(1U)) << "nobody misses who only asked";
}

TEST_F(CommandSocket, AnswerThatTakesItsTimeHoldsUpNobody) {
  const auto slow = connect();
  say(slow, "later\n");
  look();
  const auto client = connect();
  say(client, "diag\n");
  look();
  EXPECT_EQ(heard(client), "diag!\n");
  EXPECT_EQ(heard(slow), "");
  input->supply(1, "there it is", *this);
  EXPECT_EQ(heard(slow), "there it is\n");
  std::array<char, 1> more;
  EXPECT_EQ(::recv(slow.get(), more.data(), more.size(), 0), 0) << "the end comes with it, whatever others do";
  input->supply(1, "and again", *this);
}

TEST_F(CommandSocket, WhoMovesAxesIsNotPushedOutByOthers) {
  const auto moving = connect();
  say(moving, "stay\n");
  look();
  std::vector<rt::FileDescriptor> silent;
  for (std::size_t i = 0; i < 2 * CommandInput::kMaxClients; ++i) {
    silent.push_back(connect());
    look();
  }
  say(moving, "stay 2\n");
  look();
  EXPECT_EQ(heard(moving), "stay!\nstay 2!\n");
}

TEST_F(CommandSocket, AnswersALine) {
  const auto client = connect();
  say(client, "diag\n");
  look();
  EXPECT_EQ(heard(client), "diag!\n");
}

TEST_F(CommandSocket, SilentClientsHoldUpNobody) {
  const auto silent = connect();
  const auto half = connect();
  say(half, "di");
  look();
  EXPECT_TRUE(executed.empty());
  const auto client = connect();
  say(client, "diag\n");
  look();
  EXPECT_EQ(heard(client), "diag!\n");
  EXPECT_EQ(heard(half), "");
  say(half, "ag json\n");
  look();
  EXPECT_EQ(heard(half), "diag json!\n") << "what it had said before is not lost";
  EXPECT_THAT(executed, testing::ElementsAre("diag", "diag json"));
}

TEST_F(CommandSocket, ClientThatDoesNotReadGetsItsAnswerWhenItDoes) {
  answer = std::string(4'000'000, 'x');
  const auto slow = connect();
  say(slow, "diag\n");
  look();
  answer.clear();
  const auto client = connect();
  say(client, "next\n");
  look();
  EXPECT_EQ(heard(client), "next!\n");
  std::size_t bytes = 0;
  for (int i = 0; i < 10'000 && bytes < 4'000'001; ++i) {
    bytes += heard(slow).size();
    look();
  }
  EXPECT_EQ(bytes, 4'000'001U);
}

TEST_F(CommandSocket, WhoHasGoneIsForgotten) {
  answer = std::string(4'000'000, 'x');
  {
    const auto client = connect();
    say(client, "diag\n");
    look();
  }
  answer.clear();
  look();
  const auto client = connect();
  say(client, "next\n");
  look();
  EXPECT_EQ(heard(client), "next!\n");
}

TEST_F(CommandSocket, TooManySilentClientsMakeRoom) {
  std::vector<rt::FileDescriptor> silent;
  for (std::size_t i = 0; i < 3 * CommandInput::kMaxClients; ++i) {
    silent.push_back(connect());
    look();
  }
  const auto client = connect();
  say(client, "diag\n");
  look();
  EXPECT_EQ(heard(client), "diag!\n");
}

TEST_F(CommandSocket, WhoeverListensAndDoesNotAnswerIsNotWaitedForForEver) {
  // A stopped program does not read the socket.
  const auto answered = send_command(path, "diag", "run", milliseconds{30});
  ASSERT_FALSE(answered);
  EXPECT_EQ(answered.error().status, 1);
  EXPECT_EQ(answered.error().text, path + ": no answer within 30 ms; the run that listens there (process " +
                                       std::to_string(getpid()) + ") is stopped or has not started to work yet");
}

TEST_F(CommandSocket, WhereNoMoreClientsFitNobodyWaitsForEver) {
  std::vector<rt::FileDescriptor> waiting;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  do {
    waiting.emplace_back(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0));
  } while (::connect(waiting.back().get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  ASSERT_EQ(errno, EAGAIN);
  const auto answered = send_command(path, "diag", "run", milliseconds{30});
  ASSERT_FALSE(answered);
  EXPECT_THAT(answered.error().text, testing::HasSubstr("no answer within 30 ms"));
}

/// Sends a caught signal without effect repeatedly to a thread that waits for an answer.
void disturb(std::thread& waiting) {
  struct sigaction action = {};
  action.sa_handler = [](int) {};
  action.sa_flags = SA_RESTART;  // like the signals that end the program
  struct sigaction before = {};
  sigaction(SIGUSR1, &action, &before);
  for (int i = 0; i < 100; ++i) {
    pthread_kill(waiting.native_handle(), SIGUSR1);
    std::this_thread::sleep_for(milliseconds{1});
  }
  sigaction(SIGUSR1, &before, nullptr);
}

TEST_F(CommandSocket, SignalsDoNotEndTheWaitForAnAnswer) {
  auto connection = must(CommandConnection::open(path, "run"));
  Outcome<std::string> asked;
  Outcome<std::string> sent;
  std::thread waiting([&] {
    asked = connection->ask("stay");
    sent = send_command(path, "diag", "run", std::chrono::seconds{100});
  });
  disturb(waiting);
  while (executed.empty()) look();
  disturb(waiting);
  while (executed.size() < 2) look();
  waiting.join();
  ASSERT_TRUE(asked) << asked.error().text;
  EXPECT_EQ(*asked, "stay!");
  ASSERT_TRUE(sent) << sent.error().text;
  EXPECT_EQ(*sent, "diag!");
}

TEST_F(CommandSocket, LineWithoutEndIsCutOff) {
  const auto client = connect();
  say(client, std::string(80'000, 'y'));
  look();
  ASSERT_EQ(executed.size(), 1U);
  EXPECT_LE(executed[0].size(), 70'000U);
}

}  // namespace
}  // namespace driveline::cli
