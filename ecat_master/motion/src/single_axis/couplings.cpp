#include "driveline/motion/single_axis/couplings.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "driveline/rt/triple_buffer.hpp"

namespace driveline::motion {
namespace {

using trajectory::AxisSetpoint;
using trajectory::CouplingRefusal;
using trajectory::CouplingState;

/// Setpoints that differ by less than this share count as equal.
constexpr double kSamePlace = 1e-12;

trajectory::FollowLimits limits_of_axis(const AxisConfig& config) {
  return {config.limits, config.max_jerk.value_or(std::numeric_limits<double>::infinity())};
}

std::string quoted(const SingleAxes& axes, std::size_t axis) {
  return "'" + axes.axes()[axis].config().name + "'";
}

/// Whether following the masters of a pair leads back to its slave.
bool is_in_a_circle(std::span<const Couplings::Pair> pairs, const Couplings::Pair& pair) {
  auto at = pair.master;
  for (std::size_t steps = 0; steps < pairs.size(); ++steps) {
    if (at == pair.slave) return true;
    const auto next = std::find_if(pairs.begin(), pairs.end(), [at](const auto& other) { return other.slave == at; });
    if (next == pairs.end()) return false;
    at = next->master;
  }
  return at == pair.slave;
}

void check_pairs(const SingleAxes& axes, std::span<const Couplings::Pair> pairs) {
  const auto refuse = [](const std::string& reason) { throw std::invalid_argument("couplings: " + reason); };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto slave = pairs[i].slave;
    const auto master = pairs[i].master;
    const bool led_by_signal = pairs[i].signal != nullptr && master == Couplings::Pair::kNoAxis;
    if (slave >= axes.axes().size() || (master >= axes.axes().size() && !led_by_signal))
      refuse("an axis that does not exist");
    if (slave == master) refuse("axis " + quoted(axes, slave) + " cannot be its own master");
    for (std::size_t k = 0; k < i; ++k) {
      if (pairs[k].slave == slave) refuse("axis " + quoted(axes, slave) + " has two masters");
    }
  }
  for (const auto& pair : pairs) {
    if (!is_in_a_circle(pairs, pair)) continue;
    refuse("axis " + quoted(axes, pair.slave) + " and its master " + quoted(axes, pair.master) +
           " are coupled in a circle");
  }
}

}  // namespace

/// A coupling request handed to the cycle.
struct Couplings::Order {
  bool at_place = false;
  trajectory::CatchUp catch_up = trajectory::CatchUp::kPosition;
  trajectory::CouplingLaw law{};
  trajectory::Coupling::SyncPlace place{};
  std::uint64_t number = 0;   ///< shared count of orders and phases of the slave, from 1 on
  std::uint64_t request = 0;  ///< number of its request; 0: not submitted yet
};

/// The feed of a slave.
class Couplings::Feed final : public SetpointFeed {
 public:
  Feed(const SingleAxes& axes, const Pair& pair, std::chrono::nanoseconds period)
      : axes_(axes),
        pair_(pair),
        period_s_(std::chrono::duration<double>(period).count()),
        coupling_(limits_of_axis(axes.axis(pair.slave).axis().config()), period_s_) {
    coupling_.set_master_bounds(pair.signal != nullptr ? pair.signal->bounds()
                                                       : limits_of_axis(axes.axis(pair.master).axis().config()));
    coupling_.set_on_loss(pair.on_loss);
    const auto& slave = axes.axis(pair.slave).axis().config();
    ahead_s_ = dead_time_cycles(slave) * period_s_ + pair.older_s;
  }

  [[nodiscard]] std::size_t slave() const noexcept { return pair_.slave; }

  // One requesting thread at a time. The latest order replaces an earlier one, even if the cycle never took that.
  /// Stores the order before its request is submitted, so that the cycle that takes the request finds it.
  void offer(Order order) noexcept {
    before_ = asked_.order;
    order.number = ++last_number_;
    asked_.order = order;
    inbox_.write(asked_);
  }
  /// Adds the number of the request; 0: it was not submitted, and the order is withdrawn.
  void confirm(std::uint64_t request) noexcept {
    if (request == 0) {
      asked_.order = before_;
    } else {
      asked_.order.request = request;
    }
    inbox_.write(asked_);
  }
  std::uint64_t ask_phase(double offset, bool relative, const trajectory::ProfileLimits& limits) noexcept {
    asked_.phase = {offset, relative, limits, ++last_number_};
    inbox_.write(asked_);
    return last_number_;
  }

  [[nodiscard]] Report report() const noexcept {
    return {state_.load(std::memory_order_acquire),         refusal_.load(std::memory_order_relaxed),
            losses_.load(std::memory_order_relaxed),        phase_.load(std::memory_order_relaxed),
            phase_reached_.load(std::memory_order_relaxed), phase_refused_published_.load(std::memory_order_relaxed),
            phase_number_.load(std::memory_order_relaxed),  master_place_.load(std::memory_order_relaxed)};
  }

  /// Velocity of the setpoint, rad/s or m/s.
  [[nodiscard]] double velocity() const noexcept { return velocity_.load(std::memory_order_relaxed); }

  [[nodiscard]] std::size_t axis_count() const noexcept override { return 1; }
  void join(std::size_t /*axis*/, const AxisSetpoint& from) noexcept override {
    engaged_ = false;
    slave_ = from;
    master_ = master_before();
    take_orders(true);
  }
  void leave(std::size_t /*axis*/) noexcept override {
    engaged_ = false;
    publish();
  }
  [[nodiscard]] bool next(double /*period_s*/, std::span<AxisSetpoint> setpoints) noexcept override {
    notice_detours();
    take_orders(false);
    if (!engaged_ || !master_leads()) {
      engaged_ = false;
      publish();
      // A setpoint that is NaN ends the request with an error.
      setpoints[0] = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
      return true;
    }
    master_ = master_now();
    slave_ = coupling_.step(master_);
    publish();
    setpoints[0] = slave_;
    return true;
  }

 private:
  struct Phase {
    double offset = 0.0;
    bool relative = false;
    trajectory::ProfileLimits limits{};
    std::uint64_t number = 0;  ///< counted together with Order::number
  };
  struct Asked {
    Order order{};
    Phase phase{};
  };
  enum class Turn : std::uint8_t { kNow, kLater, kNever };

  static AxisSetpoint named(const SingleAxis& axis) noexcept {
    const auto& setpoint = axis.setpoint();
    return {setpoint.position + axis.position_offset(), setpoint.velocity, setpoint.acceleration};
  }
  /// State of the master at the instant that the setpoint of this cycle is for.
  [[nodiscard]] AxisSetpoint master_now() const noexcept {
    return pair_.signal != nullptr ? pair_.signal->at(ahead_s_) : named(axes_.axis(pair_.master));
  }
  /// The same for the previous cycle, at the start of this one.
  [[nodiscard]] AxisSetpoint master_before() const noexcept {
    return pair_.signal != nullptr ? pair_.signal->at(ahead_s_ - period_s_) : named(axes_.axis(pair_.master));
  }
  /// Whether the setpoints of the master are valid: not if it has failed or has no power.
  [[nodiscard]] bool master_leads() const noexcept {
    if (pair_.signal != nullptr) return pair_.signal->leads();
    const auto state = axes_.axis(pair_.master).state();
    return state != PlcopenState::kErrorStop && state != PlcopenState::kDisabled;
  }

  /// Missed periods, lost frames and its own limits move the axis away from its commanded setpoint.
  void notice_detours() noexcept {
    auto now = named(axes_.axis(pair_.slave));
    now.position -= axes_.axis(pair_.slave).on_top();
    detoured_ = std::abs(now.position - slave_.position) > kSamePlace * (1.0 + std::abs(slave_.position));
    if (!detoured_) return;
    slave_ = now;
    if (engaged_) coupling_.moved_to(now);
  }

  /// `joins`: a request has just been taken, possibly the order's, not confirmed yet.
  [[nodiscard]] Turn turn_of(const Order& order, bool joins) const noexcept {
    if (order.request == 0) return joins ? Turn::kNow : Turn::kLater;
    switch (axes_.report(order.request).phase) {
      case RequestPhase::kActive:
      case RequestPhase::kReached:
        return Turn::kNow;
      case RequestPhase::kWaiting:
        return joins ? Turn::kNow : Turn::kLater;
      default:
        return Turn::kNever;  // refused, or ended before its turn
    }
  }

  void take_orders(bool joins) noexcept {
    (void)inbox_.update();
    const auto& [order, phase] = inbox_.read();
    if (phase.number < order.number) take_phase(phase);
    if (order.number > taken_order_) {
      const auto turn = turn_of(order, joins);
      if (turn == Turn::kLater) return;
      taken_order_ = order.number;
      if (turn == Turn::kNow) take_order(order);
    }
    take_phase(phase);
  }

  void take_order(const Order& order) noexcept {
    const auto refusal = order.at_place ? coupling_.engage_at(order.law, order.place, slave_, master_)
                                        : coupling_.engage(order.law, order.catch_up, slave_, master_);
    refusal_.store(refusal, std::memory_order_relaxed);
    // A refused order leaves a coupled slave as it was.
    if (refusal != CouplingRefusal::kNone) return;
    engaged_ = true;
    phase_refused_ = false;
  }

  void take_phase(const Phase& phase) noexcept {
    if (phase.number <= taken_phase_) return;
    taken_phase_ = phase.number;
    // An impossible shift changes nothing, and is reported as a phase that is not reached.
    if (!engaged_) return;
    const double from = phase.relative ? coupling_.phase().position : 0.0;
    phase_refused_ = !coupling_.shift_phase_to(from + phase.offset, phase.limits);
  }

  void publish() noexcept {
    losses_.store(coupling_.losses(), std::memory_order_relaxed);
    phase_.store(coupling_.phase().position, std::memory_order_relaxed);
    phase_reached_.store(coupling_.phase_reached() && !phase_refused_, std::memory_order_relaxed);
    phase_refused_published_.store(phase_refused_, std::memory_order_relaxed);
    phase_number_.store(taken_phase_, std::memory_order_relaxed);
    master_place_.store(master_.position, std::memory_order_relaxed);
    velocity_.store(engaged_ ? slave_.velocity : 0.0, std::memory_order_relaxed);
    auto state = engaged_ ? coupling_.state() : CouplingState::kIdle;
    // The axis decides: it may just have left its commanded setpoint.
    if (detoured_ && state == CouplingState::kInSync) state = CouplingState::kCatchingUp;
    state_.store(state, std::memory_order_release);
  }

  const SingleAxes& axes_;
  Pair pair_;
  double period_s_;
  trajectory::Coupling coupling_;
  double ahead_s_ = 0.0;  ///< extrapolation time of `signal`, s
  bool engaged_ = false;
  bool phase_refused_ = false;
  bool detoured_ = false;  // in the last cycle
  AxisSetpoint slave_{};   // setpoint of the last cycle
  AxisSetpoint master_{};  // state of the last cycle
  std::uint64_t taken_order_ = 0;
  std::uint64_t taken_phase_ = 0;
  // Used by the requesting threads.
  Asked asked_{};
  Order before_{};
  std::uint64_t last_number_ = 0;
  rt::TripleBuffer<Asked> inbox_{};
  std::atomic<CouplingState> state_{CouplingState::kIdle};
  std::atomic<CouplingRefusal> refusal_{CouplingRefusal::kNone};
  std::atomic<std::uint32_t> losses_{0};
  std::atomic<double> phase_{0.0};
  std::atomic<double> velocity_{0.0};
  std::atomic<bool> phase_reached_{true};
  std::atomic<bool> phase_refused_published_{false};
  std::atomic<std::uint64_t> phase_number_{0};
  std::atomic<double> master_place_{0.0};
};

Couplings::Couplings(SingleAxes& axes, std::span<const Pair> pairs, std::chrono::nanoseconds period) : axes_(axes) {
  check_pairs(axes, pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    auto* const signal = pairs[i].signal;
    const auto same = [signal](const Pair& other) { return other.signal == signal; };
    if (signal != nullptr &&
        std::find_if(pairs.begin(), pairs.end(), same) == pairs.begin() + static_cast<std::ptrdiff_t>(i))
      axes.add_signal(*signal);
  }
  // Add masters first, so that a master that is itself a slave is evaluated before its own slaves.
  std::vector<Pair> left(pairs.begin(), pairs.end());
  while (!left.empty()) {
    const auto first = std::find_if(left.begin(), left.end(), [&left](const Pair& pair) {
      return std::none_of(left.begin(), left.end(), [&pair](const Pair& other) { return other.slave == pair.master; });
    });
    add(*first, period);
    left.erase(first);
  }
}

Couplings::~Couplings() = default;

void Couplings::add(const Pair& pair, std::chrono::nanoseconds period) {
  feeds_.push_back(std::make_unique<Feed>(axes_, pair, period));
  axes_.add_feed(*feeds_.back(), {pair.slave});
}

Couplings::Feed* Couplings::find(std::size_t slave) const noexcept {
  const auto found =
      std::find_if(feeds_.begin(), feeds_.end(), [slave](const auto& feed) { return feed->slave() == slave; });
  return found == feeds_.end() ? nullptr : found->get();
}

std::uint64_t Couplings::order(std::size_t slave, const Order& order) noexcept {
  auto* const feed = find(slave);
  if (feed == nullptr) return 0;
  const std::lock_guard lock(submit_mutex_);
  feed->offer(order);
  const auto request = axes_.submit(slave, {.command = AxisCommand::kFollow});
  feed->confirm(request);
  return request;
}

std::uint64_t Couplings::engage(std::size_t slave, const trajectory::CouplingLaw& law,
                                trajectory::CatchUp catch_up) noexcept {
  Order asked;
  asked.law = law;
  asked.catch_up = catch_up;
  return order(slave, asked);
}

std::uint64_t Couplings::engage_at(std::size_t slave, const trajectory::CouplingLaw& law,
                                   const trajectory::Coupling::SyncPlace& place) noexcept {
  Order asked;
  asked.at_place = true;
  asked.law = law;
  asked.place = place;
  return order(slave, asked);
}

std::uint64_t Couplings::disengage(std::size_t slave) noexcept {
  const auto* const feed = find(slave);
  if (feed == nullptr || feed->report().state == CouplingState::kIdle) return 0;
  return axes_.submit(slave, {.command = AxisCommand::kMoveVelocity, .target_si = feed->velocity()});
}

std::uint64_t Couplings::shift_phase(std::size_t slave, double offset, bool relative,
                                     const trajectory::ProfileLimits& limits) noexcept {
  auto* const feed = find(slave);
  if (feed == nullptr) return 0;
  const std::lock_guard lock(submit_mutex_);
  return feed->ask_phase(offset, relative, limits);
}

std::uint64_t Couplings::shift_phase_to(std::size_t slave, double offset,
                                        const trajectory::ProfileLimits& limits) noexcept {
  return shift_phase(slave, offset, false, limits);
}

std::uint64_t Couplings::shift_phase_by(std::size_t slave, double distance,
                                        const trajectory::ProfileLimits& limits) noexcept {
  return shift_phase(slave, distance, true, limits);
}

Couplings::Report Couplings::report(std::size_t slave) const noexcept {
  const auto* const feed = find(slave);
  return feed == nullptr ? Report{} : feed->report();
}

}  // namespace driveline::motion
