#pragma once

#include <string_view>

namespace driveline::runtime {

/// Is told what happens to a line while it is brought up, runs and is taken down. All functions are called on the
/// thread that runs the line, never on the real-time thread.
class Observer {
 public:
  virtual ~Observer() = default;
  /// A step of bring-up or take-down, as a sentence.
  virtual void progress(std::string_view /*sentence*/) {}
  /// An event in operation, as a sentence; it is in RunReport::events, too.
  virtual void event(std::string_view /*sentence*/) {}
  /// A fault, as a sentence; it is in RunReport::faults, too.
  virtual void fault(std::string_view /*sentence*/) {}
  /// Called every 20 ms in operation: the place for Line::diagnose() and Line::request_stop().
  virtual void look() {}
};

}  // namespace driveline::runtime
