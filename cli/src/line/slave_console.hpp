#pragma once

#include <string>
#include <string_view>

namespace driveline::cli {

/// Commands to the simulated slaves of a running line: faults and inputs. Belongs to one thread.
class SlaveConsole {
 public:
  SlaveConsole() = default;
  SlaveConsole(const SlaveConsole&) = delete;
  SlaveConsole& operator=(const SlaveConsole&) = delete;
  virtual ~SlaveConsole() = default;

  /// Executes a command of the user and returns the answer; on an error it starts with "error: ".
  [[nodiscard]] virtual std::string execute(std::string_view command) = 0;
  /// Takes the events since the last call.
  virtual void tell_events() = 0;
};

}  // namespace driveline::cli
