#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "axes/axis_service.hpp"
#include "commands/command_input.hpp"
#include "groups/group_service.hpp"
#include "line/slave_console.hpp"

namespace driveline::cli {

/// First word of the questions about the drives of the line.
inline constexpr std::string_view kDriveQuestion = "drive ";

/// The control socket of a running line, served by its own thread, so that a stop is accepted even while the line's
/// thread waits for a slave. Questions about the line as a whole are answered by the line's thread.
class LineControl final : private CommandExecutor {
 public:
  /// Returns the answer to a question.
  using Answer = std::function<std::string(std::string_view question)>;

  /// `couplings`: gears and cams of `axes`. `console`: the simulated line of this process, for faults and inputs; null:
  /// the slaves are on a network interface. `axes` and `groups` must outlive this object.
  LineControl(std::unique_ptr<CommandInput> input, runtime::AxisRequests& axes, runtime::GroupRequests& groups,
              runtime::CouplingPlan couplings = {}, std::unique_ptr<SlaveConsole> console = nullptr);
  LineControl(const LineControl&) = delete;
  LineControl& operator=(const LineControl&) = delete;
  /// Ends the thread and removes the socket.
  ~LineControl() override;

  /// Answers the pending questions. To be called on the thread of the line, in operation.
  void answer_questions(const Answer& answer);

 private:
  struct Question {
    std::uint64_t connection = 0;
    std::string text;  ///< the question, later the answer
  };

  [[nodiscard]] CommandReply execute(const CommandSender& sender, std::string_view command) override;
  void disconnected(const CommandSender& sender) override {
    groups_.disconnected(sender);
    axes_.disconnected(sender);
  }
  void refused(const CommandSender& sender) override { axes_.refused(sender); }
  /// Executes a command of `driveline fault` or `driveline input`.
  [[nodiscard]] std::string order_line(const CommandSender& sender, std::string_view command);
  void serve();

  std::unique_ptr<CommandInput> input_;
  std::unique_ptr<SlaveConsole> console_;
  AxisService axes_;
  GroupService groups_;
  std::mutex lock_;
  std::vector<Question> asked_;
  std::vector<Question> answered_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace driveline::cli
