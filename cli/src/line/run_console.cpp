#include "line/run_console.hpp"

#include <string>
#include <utility>
#include <vector>

#include "driveline/runtime/can/can_session.hpp"
#include "line/can_run_console.hpp"
#include "line/line_console.hpp"

namespace driveline::cli {

std::unique_ptr<SlaveConsole> make_slave_console(runtime::Line& line) {
  if (auto* can = line.can_session(); can != nullptr && can->line_calls() != nullptr) {
    return std::make_unique<CanRunConsole>(*can->line_calls(), *can->simulated_line());
  }
  auto* session = line.session();
  if (session == nullptr || session->simulated_line() == nullptr) return nullptr;
  std::vector<std::string> names;
  for (const auto& slave : line.config().slaves) names.push_back(slave.name);
  return std::make_unique<LineConsole>(*session->line_orders(), *session->simulated_line(), std::move(names),
                                       LineConsole::Events::kSilent);
}

}  // namespace driveline::cli
