#pragma once

#include <string>
#include <utility>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/runtime/observer.hpp"
#include "script/axis_script.hpp"

namespace driveline::cli {

/// Starts a script when the line waits for requests, and stops the line when the script is over.
class ScriptOperator final : public runtime::Observer {
 public:
  ScriptOperator(runtime::Line& line, AxisScript script) : line_(line), script_(std::move(script)) {}
  void event(const runtime::Event& event) override { waits_ = waits_ || event.is<runtime::events::NoPath>(); }
  void poll() override {
    if (over || !waits_) return;
    const auto done = script_.step(line_.axes(), line_.groups(), line_.clock().now());
    if (!done) problem = done.error().text;
    over = !done || *done;
    if (over) line_.request_stop();
  }

  std::string problem;  ///< problem of the script; empty: none
  bool over = false;

 private:
  runtime::Line& line_;
  AxisScript script_;
  bool waits_ = false;
};

}  // namespace driveline::cli
