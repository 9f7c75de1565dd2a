#include "line/can_run_console.hpp"

namespace driveline::cli {

std::string CanRunConsole::execute(std::string_view command) {
  constexpr std::chrono::seconds kPatience{1};
  std::string answer;
  const auto work = [&](runtime::CanLine& /*line*/) { answer = console_.execute(command); };
  if (!calls_.make(work, kPatience)) return "error: the line does not answer";
  return answer;
}

}  // namespace driveline::cli
