#pragma once

#include <string_view>

namespace driveline::runtime {

/// Hears what happens to a line while it is brought up, runs and is taken down. All functions are called on the thread
/// that runs the line, never on the real-time thread.
class Observer {
 public:
  virtual ~Observer() = default;
  /// How far it has come: a sentence.
  virtual void progress(std::string_view /*sentence*/) {}
  /// Something worth keeping has happened in operation; it is in RunReport::events, too.
  virtual void event(std::string_view /*sentence*/) {}
  /// Something is wrong; it is in RunReport::faults, too.
  virtual void fault(std::string_view /*sentence*/) {}
  /// Every 20 ms in operation: the place to ask the line something (Line::diagnose()), or for its end.
  virtual void look() {}
};

}  // namespace driveline::runtime
