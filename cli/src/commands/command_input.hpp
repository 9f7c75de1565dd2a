#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "axes/command_sender.hpp"
#include "driveline/port/file_descriptor.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// What a command is answered with.
struct CommandReply {
  std::string text;    ///< possibly several lines
  bool stays = false;  ///< further commands may follow on the connection
  bool later = false;  ///< supply() answers
};

/// Executes the commands of a CommandInput.
class CommandExecutor {
 public:
  virtual ~CommandExecutor() = default;
  /// A line from stdin or the socket.
  [[nodiscard]] virtual CommandReply execute(const CommandSender& sender, std::string_view command) = 0;
  /// A connection whose commands may follow one another has ended.
  virtual void gone(const CommandSender& sender) { static_cast<void>(sender); }
  /// A process of another user wanted to connect, and was told so.
  virtual void refused(const CommandSender& sender) { static_cast<void>(sender); }
};

/// Commands for a program that is running: lines typed on stdin, and lines sent to a local socket, each answered there.
/// A client that sends nothing, or does not read its answer, holds up neither other clients nor the program. At the
/// socket the user of the program is heard, and root.
class CommandInput {
 public:
  /// Where commands come from.
  enum class Sources : std::uint8_t { kSocketAndStdin, kSocket };

  /// Listens at the socket `path`; on stdin alone when it is empty. An old socket without a listener is replaced.
  [[nodiscard]] static Outcome<std::unique_ptr<CommandInput>> open(const std::string& path,
                                                                   Sources sources = Sources::kSocketAndStdin);
  CommandInput(const CommandInput&) = delete;
  CommandInput& operator=(const CommandInput&) = delete;
  /// Removes the socket.
  ~CommandInput();

  /// Most clients at a time; a further one replaces the oldest of those who have been told nothing yet.
  static constexpr std::size_t kMaxClients = 16;

  /// Waits for commands up to `timeout` and executes those that arrive. Answers to stdin go to stderr.
  void run(std::chrono::milliseconds timeout, CommandExecutor& executor);
  /// Answers a command that was to be answered later; a client that has gone is passed over.
  void supply(std::uint64_t connection, std::string_view text);

 private:
  explicit CommandInput(std::string path) : path_(std::move(path)) {}
  void read_stdin(CommandExecutor& executor);
  void accept_clients(CommandExecutor& executor);
  void serve_clients(CommandExecutor& executor);
  [[nodiscard]] bool make_room();

  /// A client at the socket: a command, then its answer, and again if it stays.
  struct Client {
    port::FileDescriptor socket;
    CommandSender sender;
    std::string received;   ///< of the command
    std::string answer;     ///< what is still to be sent
    bool answered = false;  ///< it is to read
    bool waits = false;     ///< for supply()
    bool stays = false;
    bool gone = false;
  };
  static void receive(Client& client, CommandExecutor& executor);
  static void send_answer(Client& client);

  std::string path_;
  port::FileDescriptor listener_;
  std::vector<Client> clients_;  ///< in the order of connection
  std::uint64_t connections_ = 0;
  bool stdin_open_ = true;
  std::string typed_;  ///< the beginning of a line
};

/// The process that listens at a socket; none: nobody does.
[[nodiscard]] std::optional<pid_t> listener_at(const std::string& path);

/// A connection to the socket of a program, for one command after the other.
class CommandConnection {
 public:
  /// Failure: nobody listens at `path`; `listener` is the program that should.
  [[nodiscard]] static Outcome<CommandConnection> open(const std::string& path, std::string_view listener);
  /// Sends a command and waits for its answer of one line.
  [[nodiscard]] Outcome<std::string> ask(std::string_view command);

 private:
  CommandConnection(std::string path, std::string_view listener, port::FileDescriptor socket)
      : path_(std::move(path)), listener_(listener), socket_(std::move(socket)) {}

  std::string path_;
  std::string listener_;
  port::FileDescriptor socket_;
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
