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
/// A client that sends nothing, or does not read its answer, holds up neither other clients nor the program.
class CommandInput {
 public:
  /// Answers a command with text, possibly of several lines.
  using Execute = std::function<std::string(std::string_view command)>;

  enum class Sources : std::uint8_t { kSocketAndStdin, kSocket };

  /// Listens at the socket `path`; on stdin alone when it is empty. An old socket without a listener is replaced.
  [[nodiscard]] static Outcome<std::unique_ptr<CommandInput>> open(const std::string& path,
                                                                   Sources sources = Sources::kSocketAndStdin);
  CommandInput(const CommandInput&) = delete;
  CommandInput& operator=(const CommandInput&) = delete;
  /// Removes the socket.
  ~CommandInput();

  /// Most clients at a time; a further one replaces the oldest.
  static constexpr std::size_t kMaxClients = 16;

  /// Waits for commands up to `timeout` and executes those that arrive. Answers to stdin go to stderr.
  void run(std::chrono::milliseconds timeout, const Execute& execute);

 private:
  explicit CommandInput(std::string path) : path_(std::move(path)) {}
  void read_stdin(const Execute& execute);
  void accept_clients();
  void serve_clients(const Execute& execute);

  /// A client at the socket: one command, then its answer.
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
  std::vector<Client> clients_;  ///< in the order of connection
  bool stdin_open_ = true;
  std::string typed_;  ///< the beginning of a line
};

/// How long to wait for an answer at a socket: far longer than the longest line takes.
inline constexpr std::chrono::milliseconds kAnswerPatience{10'000};

/// Sends one command to the socket `path` of the program `listener` and returns the answer. Failure also: no answer
/// within `patience`, from a program that is stopped or hangs.
[[nodiscard]] Outcome<std::string> send_command(const std::string& path, std::string_view command,
                                                std::string_view listener,
                                                std::chrono::milliseconds patience = kAnswerPatience);
/// The same for a `simulate`, and prints the answer; one that begins with "error: " is a failure.
[[nodiscard]] Outcome<int> order_simulation(const std::string& path, std::string_view command);

}  // namespace driveline::cli
