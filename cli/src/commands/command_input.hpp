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
#include "driveline/port/descriptor_reserve.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// The reply to a command.
struct CommandReply {
  std::string text;    ///< may have several lines
  bool stays = false;  ///< the connection stays open for further commands
  bool later = false;  ///< supply() will send the answer
};

/// Executes the commands of a CommandInput.
class CommandExecutor {
 public:
  virtual ~CommandExecutor() = default;
  /// Executes a line from stdin or the socket.
  [[nodiscard]] virtual CommandReply execute(const CommandSender& sender, std::string_view command) = 0;
  /// Handles the end of a connection that was open for further commands.
  virtual void disconnected(const CommandSender& sender) { static_cast<void>(sender); }
  /// Handles a refused connection: its process belongs to another user and has been told so.
  virtual void refused(const CommandSender& sender) { static_cast<void>(sender); }
};

/// Receives commands for a running program: lines typed on stdin, and lines sent to a local socket, each answered
/// there. A client that sends nothing, or does not read its answer, delays neither other clients nor the program. The
/// socket accepts only processes of the program's user and of root.
class CommandInput {
 public:
  /// The sources of commands.
  enum class Sources : std::uint8_t { kSocketAndStdin, kSocket };

  /// Listens at the socket `path`; on stdin alone if it is empty. A stale socket without a listener is replaced.
  [[nodiscard]] static Outcome<std::unique_ptr<CommandInput>> open(const std::string& path,
                                                                   Sources sources = Sources::kSocketAndStdin);
  CommandInput(const CommandInput&) = delete;
  CommandInput& operator=(const CommandInput&) = delete;
  /// Removes the socket.
  ~CommandInput();

  /// Most clients at a time; a new one replaces the oldest client whose connection is not kept open for further
  /// commands.
  static constexpr std::size_t kMaxClients = 16;

  /// Waits for commands up to `timeout` and executes the commands that arrive. Answers to stdin go to stderr.
  void run(std::chrono::milliseconds timeout, CommandExecutor& executor);
  /// Sends the answer to a command whose reply was `later`; ignored if the client has disconnected.
  void supply(std::uint64_t connection, std::string_view text, CommandExecutor& executor);

 private:
  explicit CommandInput(std::string path) : path_(std::move(path)) {}
  void read_stdin(CommandExecutor& executor);
  void accept_clients(CommandExecutor& executor);
  void serve_clients(CommandExecutor& executor);
  [[nodiscard]] bool make_room();

  /// A client at the socket: sends a command, then receives the answer; repeatedly if it stays.
  struct Client {
    rt::FileDescriptor socket;
    CommandSender sender;
    std::string received;   ///< bytes of the command so far
    std::string answer;     ///< bytes still to be sent
    bool answered = false;  ///< the answer is complete and is being sent
    bool waits = false;     ///< until supply() provides the answer
    bool stays = false;
    bool disconnected = false;
  };
  static void receive(Client& client, CommandExecutor& executor);
  static void send_answer(Client& client);

  std::string path_;
  rt::FileDescriptor listener_;
  port::DescriptorReserve reserve_;
  std::vector<Client> clients_;  ///< in the order of connection
  std::uint64_t connections_ = 0;
  bool stdin_open_ = true;
  std::string typed_;  ///< incomplete line from stdin
};

/// ID of the process that listens at a socket; none: no process listens.
[[nodiscard]] std::optional<pid_t> listener_at(const std::string& path);

/// A connection to the socket of a program, for any number of commands, one at a time.
class CommandConnection {
 public:
  /// Failure: no process listens at `path`; `listener` is the program that should.
  [[nodiscard]] static Outcome<CommandConnection> open(const std::string& path, std::string_view listener);
  /// Sends a command and waits for its answer, a single line.
  [[nodiscard]] Outcome<std::string> ask(std::string_view command);

 private:
  CommandConnection(std::string path, std::string_view listener, rt::FileDescriptor socket)
      : path_(std::move(path)), listener_(listener), socket_(std::move(socket)) {}

  std::string path_;
  std::string listener_;
  rt::FileDescriptor socket_;
};

/// Time-out for an answer at a socket: far longer than any line needs.
inline constexpr std::chrono::milliseconds kAnswerTimeout{10'000};

/// Sends one command to the socket `path` of the program `listener` and returns the answer. Failure also: no answer
/// within `timeout`, because the program is stopped or hangs.
[[nodiscard]] Outcome<std::string> send_command(const std::string& path, std::string_view command,
                                                std::string_view listener,
                                                std::chrono::milliseconds timeout = kAnswerTimeout);
/// The same for a simulated line, of a `simulate` or a `run`; prints the answer. An answer that starts with "error: "
/// is a failure.
[[nodiscard]] Outcome<int> order_simulation(const std::string& path, std::string_view command,
                                            std::string_view listener);

}  // namespace driveline::cli
