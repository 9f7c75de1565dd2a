#pragma once

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

/// Interface that receives the events of a line while it is brought up, runs and is shut down. All functions are called
/// on the thread that runs the line, never on the real-time thread.
class Observer {
 public:
  virtual ~Observer() = default;
  /// Receives an event; describe() makes a sentence of it. RunReport::events contains all events above
  /// Severity::kProgress, too.
  virtual void event(const Event& /*event*/) {}
  /// Called every 20 ms in operation; may call Line::diagnose() and Line::request_stop().
  virtual void poll() {}
};

}  // namespace driveline::runtime
