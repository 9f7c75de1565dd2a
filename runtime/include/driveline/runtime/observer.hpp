#pragma once

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

/// Is told what happens to a line while it is brought up, runs and is taken down. All functions are called on the
/// thread that runs the line, never on the real-time thread.
class Observer {
 public:
  virtual ~Observer() = default;
  /// What has happened; describe() makes a sentence of it. All but Severity::kProgress is in RunReport::events, too.
  virtual void event(const Event& /*event*/) {}
  /// Called every 20 ms in operation: the place for Line::diagnose() and Line::request_stop().
  virtual void look() {}
};

}  // namespace driveline::runtime
