#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/port/file_descriptor.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// Commands for a program that is running: lines typed on stdin, and lines sent to a local socket, each answered there.
/// Nobody at the socket is waited for: who says nothing, or does not take its answer, holds up neither the others nor
/// the program.
class CommandInput {
 public:
  /// Answers a command with text, possibly of several lines.
  using Execute = std::function<std::string(std::string_view command)>;

  enum class Sources : std::uint8_t { kSocketAndStdin, kSocket };

  /// Listens at the socket `path`; on stdin alone when it is empty. An old socket that nobody listens at any more is
  /// replaced.
  [[nodiscard]] static Outcome<std::unique_ptr<CommandInput>> open(const std::string& path,
                                                                   Sources sources = Sources::kSocketAndStdin);
  CommandInput(const CommandInput&) = delete;
  CommandInput& operator=(const CommandInput&) = delete;
  /// Removes the socket.
  ~CommandInput();

  /// Clients at a time; when one more comes, the one that has been there for longest is sent away.
  static constexpr std::size_t kMaxClients = 16;

  /// Waits for commands up to `timeout` and executes what has come. Answers to stdin go to stderr.
  void run(std::chrono::milliseconds timeout, const Execute& execute);

 private:
  explicit CommandInput(std::string path) : path_(std::move(path)) {}
  void read_stdin(const Execute& execute);
  void accept_clients();
  void serve_clients(const Execute& execute);

  /// Somebody at the socket: one command, then its answer.
  struct Client {
    port::FileDescriptor socket;
    std::string received;  ///< of the command
    std::string answer;    ///< what is still to be sent
    bool answered = false;
    bool gone = false;
  };
  static void receive(Client& client, const Execute& execute);
  static void send_answer(Client& client);

  std::string path_;
  port::FileDescriptor listener_;
  std::vector<Client> clients_;  ///< in the order of their coming
  bool stdin_open_ = true;
  std::string typed_;  ///< the beginning of a line
};

/// How long somebody at a socket may say nothing: far longer than the longest line takes to answer.
inline constexpr std::chrono::milliseconds kAnswerPatience{10'000};

/// Sends one command to the socket `path`, where `listener` should be; the answer. Failure: among others, that nothing
/// came for `patience`; a program that is stopped or hangs is there and does not answer.
[[nodiscard]] Outcome<std::string> send_command(const std::string& path, std::string_view command,
                                                std::string_view listener,
                                                std::chrono::milliseconds patience = kAnswerPatience);
/// The same at the `simulate` that listens there, and prints the answer; one that begins with "error: " is a failure.
[[nodiscard]] Outcome<int> order_simulation(const std::string& path, std::string_view command);

}  // namespace driveline::cli
