#include "driveline/slaves/mc7000/sequence_control.hpp"

#include <algorithm>

namespace driveline::slaves::mc7000 {
namespace {

constexpr bool bit(std::uint16_t word, unsigned number) noexcept {
  return ((word >> number) & 1U) != 0;
}

constexpr std::uint16_t kInPosition = 1U << 12U;
constexpr std::uint16_t kReferenceDefined = 1U << 13U;
constexpr std::uint16_t kProgramEnd = 1U << 14U;

}  // namespace

SequenceOrders SequenceOrders::from_control_word(std::uint16_t word) noexcept {
  return {.automatic = bit(word, 4),
          .start = bit(word, 5),
          .feed = bit(word, 6),
          .jog_positive = bit(word, 12),
          .jog_negative = bit(word, 13),
          .outputs = {bit(word, 14), bit(word, 15)}};
}

tl::expected<void, LineError> SequenceControl::command(std::string_view line) {
  if (last_.automatic) return tl::unexpected(LineError::kNotManual);
  return programs_.execute(line);
}

void SequenceControl::step(std::uint16_t control_word, bool enabled) noexcept {
  programs_.advance(period_);
  const auto orders = SequenceOrders::from_control_word(control_word);
  follow(orders);
  const auto failure = drive_.motion().failure;
  if (failure != PosModLocation::kNone && fault_ == PosModLocation::kNone) fail(failure);
  if (orders.automatic) {
    follow_automatic(orders, enabled);
  } else {
    follow_manual(orders, enabled);
  }
  last_ = orders;
}

/// Feed and outputs, which follow the control word in every mode.
void SequenceControl::follow(const SequenceOrders& orders) noexcept {
  if (!told_ || orders.feed != last_.feed) drive_.release_feed(orders.feed);
  for (std::uint8_t i = 0; i < 2; ++i) {
    if (!told_ || orders.outputs[i] != last_.outputs[i]) drive_.set_output(i, orders.outputs[i]);
  }
  told_ = true;
}

void SequenceControl::follow_manual(const SequenceOrders& orders, bool enabled) noexcept {
  if (last_.automatic) drive_.stop();
  automatic_for_ = {};
  if (fault_ == PosModLocation::kNone) state_ = SequenceState::kManual;
  const bool may_move = enabled && fault_ == PosModLocation::kNone;
  set_jog(may_move ? (orders.jog_positive ? 1 : 0) - (orders.jog_negative ? 1 : 0) : 0);
}

void SequenceControl::follow_automatic(const SequenceOrders& orders, bool enabled) noexcept {
  set_jog(0);
  const bool start_edge = orders.start && !last_.start;
  if (!last_.automatic) {
    programs_.drop_download();
    if (fault_ == PosModLocation::kNone) state_ = SequenceState::kReady;
  } else {
    automatic_for_ = std::min<std::chrono::nanoseconds>(automatic_for_ + period_, kStartDelay);
  }
  if (state_ == SequenceState::kRunning) {
    run(enabled);
  } else if (start_edge && state_ != SequenceState::kFault && automatic_for_ >= kStartDelay) {
    start(orders.feed, enabled);
  }
}

void SequenceControl::set_jog(int direction) noexcept {
  if (direction == jog_) return;
  jog_ = direction;
  drive_.jog(direction);
}

void SequenceControl::start(bool feed, bool enabled) noexcept {
  if (!enabled) {
    fail(PosModLocation::kNotEnabled);
  } else if (!feed) {
    fail(PosModLocation::kNoFeed);
  } else if (programs_.program(selected_) == nullptr) {
    fail(PosModLocation::kNoProgram);
  } else {
    // It cannot be deleted while it runs: command() refuses to outside manual mode.
    run_.start(*programs_.program(selected_));
    state_ = SequenceState::kRunning;
    run(enabled);
  }
}

void SequenceControl::run(bool enabled) noexcept {
  if (!enabled) return fail(PosModLocation::kNotEnabled);
  const auto state = run_.step();
  if (state == RunState::kEnded) state_ = SequenceState::kEnded;
  if (state == RunState::kFailed) fail(run_.fault());
}

void SequenceControl::fail(PosModLocation location) noexcept {
  fault_ = location;
  state_ = SequenceState::kFault;
  drive_.stop();
}

void SequenceControl::receive_rx_pdo21(std::span<const std::byte, ProcessValues::kRxPdo21Size> pdo) noexcept {
  const auto location = values_.receive_rx_pdo21(pdo);
  if (location != PosModLocation::kNone && fault_ == PosModLocation::kNone) fail(location);
}

void SequenceControl::acknowledge() noexcept {
  if (fault_ == PosModLocation::kNone) return;
  fault_ = PosModLocation::kNone;
  state_ = last_.automatic ? SequenceState::kReady : SequenceState::kManual;
}

void SequenceControl::restart() {
  programs_.restart();
  values_ = {};
  fault_ = PosModLocation::kNone;
  state_ = SequenceState::kManual;
  automatic_for_ = {};
  jog_ = 0;
  last_ = {};
  told_ = false;
}

std::uint16_t SequenceControl::status_bits() const noexcept {
  unsigned bits = 0;
  if (drive_.motion().in_position) bits |= kInPosition;
  if (drive_.referenced()) bits |= kReferenceDefined;
  if (state_ == SequenceState::kEnded) bits |= kProgramEnd;
  return static_cast<std::uint16_t>(bits);
}

}  // namespace driveline::slaves::mc7000
