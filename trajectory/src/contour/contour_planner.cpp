#include "driveline/trajectory/contour_planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contour/joint_path.hpp"
#include "geometry/group_math.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
/// Share of the acceleration reserved for motion along the path where the path is bent; the rest is for the bend. At
/// the highest speed of any path the share would be kShareAtTopSpeed; slower bends get proportionally less, within the
/// other two bounds, so that braking in a bend takes at most four times as long as from the highest speed on a straight
/// line.
constexpr double kShareAtTopSpeed = 0.25;
constexpr double kSmallestShare = 0.05;
constexpr double kLargestShare = 0.3;
/// Maximum number of pieces that the cycle passes in one period.
constexpr std::size_t kPiecesPerCycle = 64;
/// Minimum length of a stretch, relative to the distance covered during averaging, because the cycle looks that far
/// ahead.
constexpr double kShortestStretch = 1.0 / 16.0;
/// A stretch reaches the cycle when the next one starts, and its pieces need room until then. So a stretch may have
/// capacity / kStretchesInRoom pieces, and all stretches that may still be lowered capacity / kOpenInRoom. Together
/// with what the cycle keeps behind the axes (a quarter, and the rest of a stretch) the room is never filled by pieces
/// that wait for their stretch.
constexpr std::uint64_t kStretchesInRoom = 16;
constexpr std::uint64_t kOpenInRoom = 4;
/// Maximum number of stretches per piece, relative to the capacity, if more stretches give a higher speed.
constexpr double kByTimeInRoom = 1.0 / 64.0;
/// Divisor of the capacity for outputs and dwells on a stretch, which reach the cycle before it; includes those of one
/// move.
constexpr std::uint64_t kEventsInRoom = 2;

PathTicks to_ticks(double length) noexcept {
  return static_cast<PathTicks>(std::ceil(length / kPathTick));
}

/// Speed at which bend * v^3 + slope * v = room, by Newton's method from above, so the result is never too low.
double cubic_root(double bend, double slope, double room) noexcept {
  double v = kNoLimit;
  if (bend > 0.0) v = std::cbrt(room / bend);
  if (slope > 0.0) v = std::min(v, room / slope);
  constexpr int kSteps = 6;
  for (int k = 0; k < kSteps; ++k) {
    const double excess = v * (bend * v * v + slope) - room;
    if (excess <= 0.0) break;
    v -= excess / (3.0 * bend * v * v + slope);
  }
  return v;
}

}  // namespace

ContourPlanner::ContourPlanner(ContourTrack& track)
    : track_(track),
      settings_(track.settings()),
      check_(settings_),
      shaper_(settings_.axes, track.start(), &check_),
      smoothing_s_(static_cast<double>(track.smoothing()) * settings_.period_s),
      reach_s_(0.5 * smoothing_s_ + 2.0 * settings_.period_s),
      top_speed_(top_speed(settings_)) {
  for (std::size_t i = 0; i < settings_.axes; ++i) {
    const auto& limits = settings_.limits[i];
    limits_[i] = {limits.max_velocity, limits.max_acceleration, limits.max_jerk};
  }
  limits_[settings_.axes] = settings_.tool;
}

/// The highest speed, at most `top`, at which `share` is left of the acceleration along the path.
double ContourPlanner::top_of(const Bend& bend, double share, double top) const noexcept {
  for (std::size_t i = 0; i <= settings_.axes; ++i) {
    const auto& [f, g, h] = bend.demands[i];
    const auto& limits = limits_[i];
    if (f * top > limits.max_velocity) top = limits.max_velocity / f;
    if (g * top * top > limits.max_acceleration - share * f) top = std::sqrt((limits.max_acceleration - share * f) / g);
    const double room = limits.max_jerk - share * f / smoothing_s_;
    const double slope = 3.0 * g * share;
    if (top * (h * top * top + slope) > room) top = cubic_root(h, slope, room);
  }
  return top;
}

// With the direction r', curvature r'' and third derivative r''' of the path, an axis has
//   velocity      r' v
//   acceleration  r' a + r'' v^2
//   jerk          r' j + 3 r'' v a + r''' v^3        with j <= a / smoothing time
// For the tool, as a vector, these hold as upper bounds with the norms of the derivatives.
ContourPlanner::Bend ContourPlanner::bend_of(const PathPiece& piece, double begin, double end,
                                             double feed) const noexcept {
  const auto bounds = stretch_bounds(settings_, piece, begin, end);
  Bend bend;
  bend.is_coarse = bounds.is_coarse;
  double along = kNoLimit;
  for (std::size_t i = 0; i <= settings_.axes; ++i) {
    const bool is_tool = i == settings_.axes;
    const double first = is_tool ? 1.0 : bounds.axes.first[i];
    bend.demands[i] = {first, is_tool ? bounds.curvature : bounds.axes.second[i],
                       is_tool ? bounds.third : bounds.axes.third[i]};
    bend.is_bent = bend.is_bent || (!is_tool && (bend.demands[i].second > 0.0 || bend.demands[i].third > 0.0));
    const double most = std::min(limits_[i].max_acceleration, limits_[i].max_jerk * smoothing_s_);
    if (first > 0.0 && along * first > most) along = most / first;
  }
  const double most = std::min(top_speed_, kMaxOverride * feed);
  bend.top = top_of(bend, bend.is_bent ? kSmallestShare * along : 0.0, most);
  if (bend.is_bent) {
    const double share = std::min(kShareAtTopSpeed * bend.top / top_speed_, kLargestShare);
    if (share > kSmallestShare) bend.top = top_of(bend, share * along, bend.top);
  }
  bend.acceleration = bend.is_bent ? std::min(along, acceleration_at(bend, bend.top)) : along;
  return bend;
}

/// Acceleration along the path that is left at `speed` where the path is bent.
double ContourPlanner::acceleration_at(const Bend& bend, double speed) const noexcept {
  double left = kNoLimit;
  for (std::size_t i = 0; i <= settings_.axes; ++i) {
    const auto& [f, g, h] = bend.demands[i];
    const auto& limits = limits_[i];
    const double room = limits.max_acceleration - g * speed * speed;
    if (f * left > room) left = room / f;
    const double per_acceleration = f / smoothing_s_ + 3.0 * g * speed;
    const double jerk = limits.max_jerk - h * speed * speed * speed;
    if (per_acceleration * left > jerk) left = jerk / per_acceleration;
  }
  return left;
}

tl::expected<void, PathMoveError> ContourPlanner::add(const PathMove& move) {
  shaped_.clear();
  if (auto added = shaper_.add(move, shaped_); !added) return added;
  for (const auto& shaped : shaped_) plan(shaped);
  return {};
}

void ContourPlanner::finish() {
  shaped_.clear();
  shaper_.finish(shaped_);
  for (const auto& shaped : shaped_) plan(shaped);
}

/// Speed at which the cycle does not pass too many pieces in one period.
double ContourPlanner::top_for_short_pieces(double length) noexcept {
  if (lengths_.size() < kPiecesPerCycle) {
    lengths_.push_back(length);
    sum_of_lengths_ += length;
    return kNoLimit;
  }
  // Sum up again from time to time, because differences accumulate rounding errors.
  sum_of_lengths_ += length - lengths_[next_length_];
  lengths_[next_length_] = length;
  next_length_ = (next_length_ + 1) % kPiecesPerCycle;
  if (next_length_ == 0) {
    sum_of_lengths_ = 0.0;
    for (const double each : lengths_) sum_of_lengths_ += each;
  }
  return sum_of_lengths_ / settings_.period_s;
}

void ContourPlanner::plan(const ShapedPiece& shaped) {
  const PathTicks begin = shaped_end_;
  const PathTicks length = std::llround(shaped.piece.length() / kPathTick);
  const auto first_event = planned_events_;
  plan_events(shaped, begin, length);
  if (length <= 0) return;
  shaped_end_ += length;
  put_piece({begin, shaped_end_, shaped.piece, shaped.move});
  const auto number = planned_pieces_++;
  plan_stretches(shaped, {begin, shaped_end_, kNoLimit, 0.0, shaped.feed, shaped.stops, number, number, first_event,
                          planned_events_});
}

/// Publishes the piece to the cycle at once if there is room: no stretch refers to it yet.
void ContourPlanner::put_piece(const ContourTrack::Piece& piece) {
  const auto end = track_.pieces_end_.load(std::memory_order_relaxed);
  if (!pieces_.empty() || end - track_.pieces_begin_.load(std::memory_order_acquire) > track_.mask_) {
    pieces_.push_back(piece);
    return;
  }
  track_.piece(end) = piece;
  track_.pieces_end_.store(end + 1, std::memory_order_release);
}

void ContourPlanner::plan_events(const ShapedPiece& shaped, PathTicks begin, PathTicks length) {
  for (const auto& event : shaped.events) {
    const double share = shaped.piece.length() > 0.0 ? event.at / shaped.piece.length() : 0.0;
    const auto along = static_cast<PathTicks>(std::round(share * static_cast<double>(length)));
    const auto cycles = static_cast<std::uint64_t>(std::ceil(event.dwell_s / settings_.period_s));
    events_.push_back({begin + std::clamp<PathTicks>(along, 0, length), cycles, event.change});
    ++planned_events_;
  }
}

void ContourPlanner::plan_stretches(const ShapedPiece& shaped, const Stretch& whole) {
  const double length = shaped.piece.length();
  const double most = top_for_short_pieces(length);
  if (settings_.kinematics != nullptr) {
    constexpr int kHalvings = 10;
    Stretch stretch = whole;
    stretch.top = most;
    plan_stretches_of_joints(shaped, stretch, 0.0, length, kHalvings);
    return;
  }
  const auto bend_of_whole = bend_of(shaped.piece, 0.0, length, shaped.feed);
  int count = 1;
  if (!shaped.piece.is_line()) {
    // Pieces that last longer than the averaging are subdivided; arcs need short stretches for good bounds.
    constexpr double kShortTurn = 0.25;
    constexpr double kMaxStretches = 64.0;
    const double most_by_time = std::clamp(kByTimeInRoom * static_cast<double>(settings_.capacity), 16.0, 128.0);
    const double by_time = length / (0.25 * smoothing_s_ * bend_of_whole.top);
    const double by_turn = shaped.piece.is_flat() ? 0.0 : length * norm(shaped.piece.at(0.0).second) / kShortTurn;
    count =
        static_cast<int>(std::ceil(std::max({1.0, std::min(by_turn, kMaxStretches), std::min(by_time, most_by_time)})));
  }
  Stretch part = whole;
  part.top = most;
  for (int k = 0; k < count; ++k) {
    // Divide before multiplying: the product may overflow.
    part.end = k + 1 == count ? whole.end : whole.begin + (whole.end - whole.begin) / count * (k + 1);
    if (part.end > part.begin) {
      part.stops = whole.stops && k + 1 == count;
      append(part, count == 1 ? bend_of_whole
                              : bend_of(shaped.piece, length * k / count, length * (k + 1) / count, shaped.feed));
    }
    part.begin = part.end;
  }
}

/// The limits of joints vary along a straight line, too: stretches are halved while one takes longer than the averaging
/// time, or its bounds are too coarse.
void ContourPlanner::plan_stretches_of_joints(const ShapedPiece& shaped, const Stretch& stretch, double begin,
                                              double end, int halvings) {
  constexpr int kForTime = 4;
  const auto bend = bend_of(shaped.piece, begin, end, shaped.feed);
  const bool is_long = halvings > kForTime && end - begin > smoothing_s_ * bend.top;
  const PathTicks middle = stretch.begin + (stretch.end - stretch.begin) / 2;
  if (halvings > 0 && (bend.is_coarse || is_long) && middle > stretch.begin) {
    Stretch half = stretch;
    half.end = middle;
    half.stops = false;
    plan_stretches_of_joints(shaped, half, begin, 0.5 * (begin + end), halvings - 1);
    half = stretch;
    half.begin = middle;
    plan_stretches_of_joints(shaped, half, 0.5 * (begin + end), end, halvings - 1);
    return;
  }
  append(stretch, bend);
}

// Consecutive short pieces form one stretch, with the lower limits.
void ContourPlanner::append(const Stretch& stretch, const Bend& bend) {
  Stretch next = stretch;
  next.top = std::min(bend.top, stretch.top);
  next.acceleration = bend.acceleration;
  if (gathered_ && merge(gathered_->stretch, next)) {
    for (std::size_t i = 0; i <= settings_.axes; ++i) {
      auto& of_both = gathered_->bend.demands[i];
      const auto& more = bend.demands[i];
      of_both.first = std::max(of_both.first, more.first);
      of_both.second = std::max(of_both.second, more.second);
      of_both.third = std::max(of_both.third, more.third);
    }
    gathered_->bend.is_bent = gathered_->bend.is_bent || bend.is_bent;
  } else {
    if (gathered_) append_curved(*gathered_);
    gathered_ = Curved{next, bend, 0.0};
  }
  if (!stretch.stops) return;
  append_curved(*gathered_);
  gathered_.reset();
}

// While the mean of the last positions is at a point, the positions themselves are within half of the distance covered
// during the averaging. So the limits of a stretch must also hold in that neighbourhood.
void ContourPlanner::append_shaped(const Stretch& shaped) {
  Stretch stretch = shaped;
  stretch.top = std::min(stretch.top, top_for_room(stretch));
  const PathTicks reach = to_ticks(stretch.top * reach_s_);
  tops_.lower(stretch.begin - reach, stretch.end + reach, stretch.top);
  accelerations_.lower(stretch.begin - reach, stretch.end + reach, stretch.acceleration);
  open_.push_back(stretch);
  if (stretch.stops) {
    // The axes stop here until the mean has arrived as well.
    settle(std::numeric_limits<PathTicks>::max());
    tops_.clear();
    accelerations_.clear();
    early_end_.reset();
    return;
  }
  settle(stretch.end - to_ticks(top_speed_ * reach_s_));
  settle_beyond_room();
}

/// With many short pieces, settles stretches far behind although a fast stretch could still lower them.
void ContourPlanner::settle_beyond_room() {
  const std::uint64_t kept = settings_.capacity / kOpenInRoom;
  while (open_.size() > 1 && open_.back().last_piece - open_[1].first_piece >= kept) {
    early_end_ = open_.front().end;
    settle_one(open_.front());
    open_.pop_front();
  }
}

/// Speed at which a stretch lowers nothing that was settled early.
double ContourPlanner::top_for_room(const Stretch& stretch) const noexcept {
  if (!early_end_) return kNoLimit;
  // One step less, for rounding.
  const auto open = static_cast<double>(stretch.begin - *early_end_ - 1);
  return open * kPathTick / reach_s_;
}

/// Settles the stretches that end up to `until`: they will not be lowered any more.
void ContourPlanner::settle(PathTicks until) {
  while (!open_.empty() && open_.front().end <= until) {
    settle_one(open_.front());
    open_.pop_front();
  }
}

/// Whether two stretches may merge with regard to stops and the numbers of pieces and events.
bool ContourPlanner::may_be_one(const Stretch& last, const Stretch& stretch) const noexcept {
  return !last.stops && stretch.last_piece - last.first_piece < settings_.capacity / kStretchesInRoom &&
         stretch.last_event - last.first_event < settings_.capacity / kEventsInRoom;
}

/// Merges two stretches if they are equal or short, or if the one with the higher limits is very short, because the
/// limits of the other one extend over it anyway. An example is half a nanometre of a line between two blends.
bool ContourPlanner::merge(Stretch& last, const Stretch& stretch) const noexcept {
  if (!may_be_one(last, stretch)) return false;
  const bool same_feed = last.feed == stretch.feed;
  const bool is_same = same_feed && last.top == stretch.top && last.acceleration == stretch.acceleration;
  const double lower = std::min(last.top, stretch.top);
  const auto shortest = static_cast<PathTicks>(kShortestStretch * lower * smoothing_s_ / kPathTick);
  const bool is_short = stretch.end - last.begin <= shortest;
  const bool last_is_spare = same_feed && last.end - last.begin <= shortest && last.top >= stretch.top &&
                             last.acceleration >= stretch.acceleration;
  const PathTicks spare = last.spare + (stretch.end - stretch.begin);
  const bool is_spare =
      same_feed && spare <= shortest && stretch.top >= last.top && stretch.acceleration >= last.acceleration;
  if (!is_same && !is_short && !last_is_spare && !is_spare) return false;
  last.spare = is_spare && !is_same ? spare : 0;
  last.end = stretch.end;
  last.last_piece = stretch.last_piece;
  last.last_event = stretch.last_event;
  last.top = lower;
  last.acceleration = std::min(last.acceleration, stretch.acceleration);
  last.feed = std::min(last.feed, stretch.feed);
  last.stops = stretch.stops;
  return true;
}

/// Settles a stretch in parts, with the limits from itself and its neighbourhood.
void ContourPlanner::settle_one(const Stretch& whole) {
  Stretch part = whole;
  while (true) {
    tops_.forget(part.begin);
    accelerations_.forget(part.begin);
    part.top = tops_.value();
    part.acceleration = accelerations_.value();
    part.end = std::min({whole.end, tops_.end(), accelerations_.end()});
    part.stops = whole.stops && part.end == whole.end;
    if (settled_.empty() || !merge(settled_.back(), part)) settled_.push_back(part);
    if (part.end == whole.end) return;
    part.begin = part.end;
  }
}

bool ContourPlanner::flush() {
  // Pieces first, because cells refer to them.
  return publish_pieces() && publish_cells();
}

bool ContourPlanner::publish_pieces() {
  auto end = track_.pieces_end_.load(std::memory_order_relaxed);
  const auto begin = track_.pieces_begin_.load(std::memory_order_acquire);
  while (!pieces_.empty() && end - begin <= track_.mask_) {
    track_.piece(end++) = pieces_.front();
    pieces_.pop_front();
  }
  track_.pieces_end_.store(end, std::memory_order_release);
  return pieces_.empty();
}

/// Publishes events; returns whether all events up to a position are known to the cycle.
bool ContourPlanner::publish_events(PathTicks until) {
  auto end = track_.events_end_.load(std::memory_order_relaxed);
  const auto begin = track_.events_begin_.load(std::memory_order_acquire);
  while (!events_.empty() && events_.front().at <= until && end - begin <= track_.mask_) {
    track_.event(end++) = events_.front();
    events_.pop_front();
  }
  track_.events_end_.store(end, std::memory_order_release);
  return events_.empty() || events_.front().at > until;
}

bool ContourPlanner::publish_cells() {
  const auto first_new = track_.cells_end_.load(std::memory_order_relaxed);
  const auto begin = track_.cells_begin_.load(std::memory_order_acquire);
  auto end = first_new;
  // The last stretch may still grow, unless the axes stop at its end.
  while (!settled_.empty() && (settled_.size() > 1 || settled_.front().stops) && end - begin <= track_.mask_) {
    const auto& from = settled_.front();
    if (!publish_events(from.end)) break;
    auto& cell = track_.cell(end++);
    cell.begin = from.begin;
    cell.end = from.end;
    cell.top = from.top;
    cell.acceleration = from.acceleration;
    cell.feed = from.feed;
    cell.behind2 = std::min(reverse2_, std::min(last_top_, from.top) * std::min(last_top_, from.top));
    cell.brakes2 = brakes2_;
    const double braked2 = 2.0 * from.acceleration * static_cast<double>(from.end - from.begin) * kPathTick;
    brakes2_ += braked2;
    reverse2_ = from.stops ? 0.0 : std::min(cell.behind2 + braked2, from.top * from.top);
    last_top_ = from.top;
    cell.ahead2.store(from.stops ? -1.0 : 0.0, std::memory_order_relaxed);
    settled_.pop_front();
  }
  raise_speeds(first_new, end);
  return settled_.empty() || (settled_.size() == 1 && !settled_.front().stops);
}

// Raises the new cells first, then the old ones, from the end backwards: a reader that sees a raised speed also sees
// everything ahead of it.
void ContourPlanner::raise_speeds(std::uint64_t first_new, std::uint64_t end) {
  if (end == first_new) return;
  const auto oldest = track_.cells_begin_.load(std::memory_order_acquire);
  double at_begin2 = 0.0;  // square of the speed at the start of the following cell
  double top_behind = 0.0;
  for (std::uint64_t index = end; index-- > oldest;) {
    if (index + 1 == first_new) track_.cells_end_.store(end, std::memory_order_release);
    auto& cell = track_.cell(index);
    const double known2 = cell.ahead2.load(std::memory_order_relaxed);
    const double top = std::min(cell.top, top_behind);
    // Negative: the axes always stop at the end of the cell.
    const double at_end2 = known2 < 0.0 ? known2 : std::min(at_begin2, top * top);
    if (index < first_new && (known2 < 0.0 || at_end2 <= known2)) return;
    cell.ahead2.store(at_end2, std::memory_order_release);
    at_begin2 =
        std::max(0.0, at_end2) + 2.0 * cell.acceleration * static_cast<double>(cell.end - cell.begin) * kPathTick;
    top_behind = cell.top;
  }
  track_.cells_end_.store(end, std::memory_order_release);
}

}  // namespace driveline::trajectory
