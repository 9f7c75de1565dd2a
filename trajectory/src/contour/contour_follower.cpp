#include "driveline/trajectory/contour_follower.hpp"

#include <algorithm>
#include <cmath>

#include "contour/joint_path.hpp"

namespace driveline::trajectory {
namespace {

/// Upper bound for the iterations of any loop of the cycle. Stretches and pieces are made such that fewer are needed.
constexpr int kMaxRounds = 128;
/// A change of the speed below this fraction of the largest change per cycle counts as rounding.
constexpr double kNoChange = 1e-9;
/// Distance, m or rad, below which the end counts as reached.
constexpr double kArrived = 1e-11;
/// Cycles in addition to the averaging window between two accelerations of different sign, because differences of
/// positions span two cycles.
constexpr std::int64_t kApart = 2;

double to_length(PathTicks ticks) noexcept {
  return static_cast<double>(ticks) * kPathTick;
}

}  // namespace

ContourFollower::ContourFollower(ContourTrack& track)
    : track_(track),
      period_s_(track.settings().period_s),
      window_(static_cast<std::int64_t>(track.smoothing())),
      since_rise_(window_ + kApart),
      since_fall_(window_ + kApart),
      places_(track.smoothing(), 0),
      speeds_(track.smoothing(), 0.0) {}

bool ContourFollower::set_override(double share) noexcept {
  if (!(share >= 0.0 && share <= kMaxOverride)) return false;
  override_ = share;
  return true;
}

bool ContourFollower::has_next_cell(std::uint64_t index) noexcept {
  if (index + 1 < cells_known_) return true;
  cells_known_ = track_.cells_end_.load(std::memory_order_acquire);
  return index + 1 < cells_known_;
}

void ContourFollower::find_cell() noexcept {
  const auto oldest = track_.cells_begin_.load(std::memory_order_relaxed);
  for (int round = 0; round < kMaxRounds; ++round) {
    const Cell& cell = track_.cell(cell_);
    if (direction_ > 0 && place_ >= cell.end && has_next_cell(cell_)) {
      ++cell_;
    } else if (direction_ < 0 && place_ <= cell.begin && cell_ > oldest) {
      --cell_;
    } else {
      return;
    }
  }
}

PathTicks ContourFollower::ticks_to_end(const Cell& cell) const noexcept {
  return direction_ > 0 ? cell.end - place_ : place_ - cell.begin;
}

/// Square of the highest speed at the end of a cell in the direction of the motion.
double ContourFollower::far_speed2(const Cell& cell, std::uint64_t index) noexcept {
  if (direction_ > 0) {
    // Keep this order: if the loaded speed is above zero, the next cell is visible.
    const double ahead2 = cell.ahead2.load(std::memory_order_acquire);
    return has_next_cell(index) ? std::max(0.0, ahead2) : 0.0;
  }
  const auto oldest = track_.cells_begin_.load(std::memory_order_relaxed);
  if (index == oldest) return 0.0;
  return std::max(0.0, std::min(cell.behind2, cell.brakes2 - track_.cell(oldest).brakes2));
}

/// The highest speed up to `speed` that can be used in this cycle and held for `coast_s` before braking must start.
double ContourFollower::allowed(double speed, double coast_s) noexcept {
  auto index = cell_;
  const Cell* cell = &track_.cell(index);
  double near = to_length(ticks_to_end(*cell));
  for (int round = 0; round < kMaxRounds; ++round) {
    speed = std::min(speed, cell->top);
    const double end2 = far_speed2(*cell, index);
    if (speed * speed > end2) {
      // v^2 = end2 + 2 a (near - distance), with distance = (speed + v) / 2 period + v coast.
      const double slope = cell->acceleration * (coast_s + 0.5 * period_s_);
      const double rest = end2 + 2.0 * cell->acceleration * (near - 0.5 * speed_ * period_s_);
      const double square = slope * slope + rest;
      const double braking = square > slope * slope ? std::sqrt(square) - slope : 0.0;
      speed = std::min(speed, std::max(std::sqrt(end2), braking));
    }
    const double way = 0.5 * (speed_ + speed) * period_s_ + speed * coast_s;
    if (way <= near || end2 <= 0.0) return speed;
    index = direction_ > 0 ? index + 1 : index - 1;
    cell = &track_.cell(index);
    near += to_length(cell->end - cell->begin);
  }
  return 0.0;
}

double ContourFollower::wanted_speed(const Cell& cell) const noexcept {
  const bool is_against = (direction_ < 0) != backwards_;
  return held_ || is_against || override_ <= 0.0 ? 0.0 : override_ * cell.feed;
}

// Accelerations of different sign are farther apart than the averaging time, so that the jerk of the mean does not
// exceed acceleration / averaging time. Therefore the speed rises only where it can be held that long before it must
// fall.
double ContourFollower::next_speed(const Cell& cell) noexcept {
  const double change = cell.acceleration * period_s_;
  const double wanted = wanted_speed(cell);
  const auto since_faster = direction_ > 0 ? since_rise_ : since_fall_;
  const auto since_slower = direction_ > 0 ? since_fall_ : since_rise_;
  double next = speed_;
  if (wanted > speed_ && since_slower >= window_ + kApart) {
    const double coast_s = static_cast<double>(window_ + kApart + 1) * period_s_;
    next = std::max(speed_, allowed(std::min(wanted, speed_ + change), coast_s));
  } else if (wanted < speed_ && since_faster >= window_ + kApart) {
    next = std::max(wanted, speed_ - change);
  }
  const double most = allowed(next, 0.0);
  if (most >= next - kNoChange * change) return next;
  // Braking. If a cell with a higher limit starts within this cycle, use its limit.
  const double harder = direction_ > 0 && has_next_cell(cell_) ? track_.cell(cell_ + 1).acceleration * period_s_
                        : direction_ < 0 && cell_ > track_.cells_begin_.load(std::memory_order_relaxed)
                            ? track_.cell(cell_ - 1).acceleration * period_s_
                            : change;
  return std::max(most, speed_ - std::max(change, harder));
}

void ContourFollower::advance(double speed) noexcept {
  const Cell* cell = &track_.cell(cell_);
  const double way = 0.5 * (speed_ + speed) * period_s_;
  // At least one step, otherwise the axes would never cover the last steps.
  auto ticks = static_cast<PathTicks>(std::max(way > 0.0 ? 1.0 : 0.0, std::round(way / kPathTick)));
  // Never move beyond a position where the axes must stop.
  PathTicks near = ticks_to_end(*cell);
  auto index = cell_;
  for (int round = 0; round < kMaxRounds && (near <= ticks || round == 0); ++round) {
    if (far_speed2(*cell, index) <= 0.0) {
      const bool arrives = speed * period_s_ <= kArrived && wanted_speed(*cell) > 0.0 && to_length(near) <= kArrived;
      // Stop here, even with a speed left by rounding.
      if (arrives || ticks >= near) {
        ticks = near;
        speed = 0.0;
      }
      break;
    }
    index = direction_ > 0 ? index + 1 : index - 1;
    cell = &track_.cell(index);
    near += cell->end - cell->begin;
  }
  const double change = direction_ * (speed - speed_);
  const double rounding = kNoChange * track_.cell(cell_).acceleration * period_s_;
  since_rise_ = change > rounding ? 0 : since_rise_ + 1;
  since_fall_ = change < -rounding ? 0 : since_fall_ + 1;
  speed_ = speed;

  const PathTicks moved = direction_ * ticks;
  place_ += moved;
  const double signed_speed = direction_ * speed_;
  const PathTicks whole = place_ - places_[oldest_];
  const double gained = signed_speed - speeds_[oldest_];
  lag_ += window_ * moved - whole;
  places_[oldest_] = place_;
  speeds_[oldest_] = signed_speed;
  oldest_ = oldest_ + 1 == places_.size() ? 0 : oldest_ + 1;
  const auto count = static_cast<double>(window_);
  mean_speed_ = (to_length(whole) / period_s_ + 0.5 * gained) / count;
  mean_acceleration_ = gained / (count * period_s_);
}

/// Position of the mean on its piece.
double ContourFollower::local_length() noexcept {
  return to_length(place_ - track_.piece(piece_).begin) - to_length(lag_) / static_cast<double>(window_);
}

void ContourFollower::find_piece() noexcept {
  const auto oldest = track_.pieces_begin_.load(std::memory_order_relaxed);
  for (int round = 0; round < kMaxRounds; ++round) {
    const double local = local_length();
    const auto& piece = track_.piece(piece_);
    if (local > to_length(piece.end - piece.begin)) {
      if (piece_ + 1 >= pieces_known_) pieces_known_ = track_.pieces_end_.load(std::memory_order_acquire);
      if (piece_ + 1 >= pieces_known_) return;
      ++piece_;
    } else if (local < 0.0 && piece_ > oldest) {
      --piece_;
    } else {
      return;
    }
  }
}

// On the way forwards, returns stored data far behind the axes to the planner: first the cells, then the pieces that no
// cell needs.
void ContourFollower::forget() noexcept {
  const std::uint64_t kept = track_.settings().capacity / 4;
  auto cells = track_.cells_begin_.load(std::memory_order_relaxed);
  auto pieces = track_.pieces_begin_.load(std::memory_order_relaxed);
  const auto first_cell = cells;
  const auto first_piece = pieces;
  // Do not access what has been returned: the planner may be writing there.
  const PathTicks needed = piece_ > pieces + kept ? track_.piece(piece_ - kept).begin : 0;
  // The mean lags behind, so its piece is always retained.
  const PathTicks mean = track_.piece(piece_).begin;
  for (int round = 0; round < kMaxRounds; ++round) {
    const Cell& oldest = track_.cell(cells);
    if (oldest.end > mean || (oldest.begin >= needed && cell_ - cells <= kept)) break;
    ++cells;
  }
  const PathTicks begin = track_.cell(cells).begin;
  for (int round = 0; round < kMaxRounds && pieces < piece_ && track_.piece(pieces).end <= begin; ++round) ++pieces;
  if (cells != first_cell) track_.cells_begin_.store(cells, std::memory_order_release);
  if (pieces != first_piece) track_.pieces_begin_.store(pieces, std::memory_order_release);
}

const ContourTrack::Event* ContourFollower::next_event(std::uint64_t ahead) noexcept {
  if (event_ + ahead >= events_known_) events_known_ = track_.events_end_.load(std::memory_order_acquire);
  return event_ + ahead < events_known_ ? &track_.event(event_ + ahead) : nullptr;
}

void ContourFollower::forget_event() noexcept {
  dwelt_ = 0;
  track_.events_begin_.store(++event_, std::memory_order_release);
}

/// Whether the point must stay where it is: there is a dwell, possibly after outputs that the mean has not yet reached.
bool ContourFollower::is_dwelling() noexcept {
  if (speed_ > 0.0) return false;
  if (backwards_) {
    dwelt_ = 0;
    return false;
  }
  for (std::uint64_t ahead = 0; ahead < 2 * kMaxOutputsOfMove; ++ahead) {
    const auto* const event = next_event(ahead);
    if (event == nullptr || event->at != place_) return false;
    if (event->dwell_cycles == 0) continue;
    if (ahead > 0 || lag_ != 0) return true;
    if (!held_) ++dwelt_;
    if (dwelt_ >= event->dwell_cycles) forget_event();
    return true;
  }
  return false;
}

void ContourFollower::tell_outputs(ContourSetpoint& out) noexcept {
  while (out.changes < out.changed.size()) {
    const auto* const event = next_event();
    if (event == nullptr || event->at > place_ || (place_ - event->at) * window_ < lag_) return;
    if (event->dwell_cycles > 0) {
      // A dwell remains until it is over.
      if (event->at == place_) return;
    } else {
      out.changed[out.changes++] = event->change;
    }
    forget_event();
  }
}

ContourSetpoint ContourFollower::setpoint() noexcept {
  ContourSetpoint out;
  const auto& piece = track_.piece(piece_);
  // Scale by the fraction of the piece: its length in steps is rounded, so pieces would otherwise join with an offset
  // of half a step.
  const double share = local_length() / to_length(piece.end - piece.begin);
  const double local = std::clamp(share, 0.0, 1.0) * piece.shape.length();
  const auto there = piece.shape.at(local);
  out.tool = there.position;
  // The planner has checked that this cannot fail on the path.
  to_joints(track_.settings_, there, joints_);
  out.position = joints_.position;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    out.velocity[i] = joints_.first[i] * mean_speed_;
    out.acceleration[i] = joints_.first[i] * mean_acceleration_ + joints_.second[i] * mean_speed_ * mean_speed_;
  }
  out.move = piece.move;
  out.length = to_length(piece.begin) + local;
  out.speed = mean_speed_;
  out.at_rest = speed_ <= 0.0 && lag_ == 0 && since_rise_ >= window_ && since_fall_ >= window_;
  const Cell& cell = track_.cell(cell_);
  out.at_end =
      out.at_rest && (backwards_ ? cell_ == track_.cells_begin_.load(std::memory_order_relaxed) && place_ <= cell.begin
                                 : !has_next_cell(cell_) && place_ >= cell.end);
  tell_outputs(out);
  const auto* const event = next_event();
  out.dwells = dwells_ && lag_ == 0;
  out.at_end = out.at_end && !dwells_ && (backwards_ || event == nullptr || event->at > place_);
  return out;
}

ContourSetpoint ContourFollower::step() noexcept {
  if (cells_known_ == 0) {
    cells_known_ = track_.cells_end_.load(std::memory_order_acquire);
    if (cells_known_ == 0) {
      ContourSetpoint out;
      out.position = track_.start_joints_;
      out.tool = track_.start_;
      return out;
    }
  }
  if (speed_ <= 0.0) direction_ = backwards_ ? -1 : 1;
  find_cell();
  dwells_ = is_dwelling();
  advance(dwells_ ? 0.0 : next_speed(track_.cell(cell_)));
  find_piece();
  if (direction_ > 0) forget();
  return setpoint();
}

}  // namespace driveline::trajectory
