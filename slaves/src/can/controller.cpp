#include "driveline/slaves/can/controller.hpp"

namespace driveline::slaves::can {

void Node::transmitted(const Frame& /*frame*/, nanoseconds /*now*/) {}

void Node::error_state_changed(ErrorState /*state*/, nanoseconds /*now*/) {}

Controller::Controller(Node& node, const ControllerOptions& options)
    : node_(&node), options_(options), queue_(options.queue_capacity), bit_rate_(options.bit_rate) {
  use_bit_rate();
}

void Controller::use_bit_rate() noexcept {
  options_.bit_rate = held_bit_rate_.value_or(bit_rate_);
  bit_time_ = nanoseconds{1'000'000'000 / options_.bit_rate};
}

bool Controller::send(const Frame& frame) noexcept {
  return takes_part() && queue_.push(frame);
}

void Controller::recover(nanoseconds now) noexcept {
  if (errors_.state() == ErrorState::kBusOff && !recovery_.running()) recovery_.start(now);
}

void Controller::set_power(bool on) noexcept {
  powered_ = on;
  if (!on) restart();
}

void Controller::set_supply(bool on) noexcept {
  supplied_ = on;
  if (!on) restart();
}

void Controller::fail(nanoseconds now) {
  if (!takes_part()) return;
  const ErrorState before = errors_.state();
  while (errors_.state() != ErrorState::kBusOff) errors_.transmit_error();
  sending_.reset();
  report(before, now);
}

void Controller::restart() noexcept {
  queue_.clear();
  sending_.reset();
  errors_.reset();
  recovery_.stop();
}

const Frame* Controller::competing() const noexcept {
  if (!takes_part()) return nullptr;
  return babble_ ? &*babble_ : queue_.front();
}

void Controller::begin() noexcept {
  sending_ = *competing();
  if (!babble_) queue_.pop();
}

void Controller::sent(nanoseconds now) {
  const Frame frame = *sending_;
  sending_.reset();
  const ErrorState before = errors_.state();
  errors_.sent();
  report(before, now);
  node_->transmitted(frame, now);
  if (options_.loop_back) node_->receive(frame, now);
  look();
}

void Controller::retry() noexcept {
  if (sending_ && !babble_) queue_.put_back(*sending_);
  sending_.reset();
}

/// In bus off nothing waits any more.
void Controller::state_changed(nanoseconds now) {
  const ErrorState state = errors_.state();
  if (state == ErrorState::kBusOff) {
    queue_.clear();
    if (options_.automatic_recovery) recovery_.start(now);
  }
  node_->error_state_changed(state, now);
  look();
}

void Controller::recovered(nanoseconds now) {
  recovery_.stop();
  errors_.reset();
  node_->error_state_changed(ErrorState::kActive, now);
  look();
}

}  // namespace driveline::slaves::can
