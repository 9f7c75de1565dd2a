#include "bridge.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

#include "confinement.hpp"
#include "feed_config.hpp"
#include "shared_room.hpp"
#include "stale_segments.hpp"

namespace driveline::bridge {
namespace {

/// Maximum number of cycles per pass, so that status and counts are reported in between.
constexpr int kCyclesPerPass = 512;
/// Longest time between two passes over an empty feed: the process of the line wakes the bridge for every batch.
constexpr std::chrono::milliseconds kPause{2};
/// Time limit for publishing the rest of the feed and for subscribers to receive it.
constexpr unsigned kFarewellSeconds = 5;
/// A process of the line that reports nothing for this long has stalled: it normally reports every 50 ms.
constexpr std::chrono::seconds kStandsStill{1};
/// Longest message to the supervisor.
constexpr std::size_t kLongestMessage = 500;
/// Message for shared memory, which requires system calls on files, on a kernel that cannot restrict the files.
constexpr std::string_view kNoLimits =
    "shared memory: this kernel has no Landlock (Linux 5.13), so the bridge can open all files of its user, not only "
    "those in /dev/shm";
constexpr std::string_view kNoRoom =
    "shared memory: /dev/shm has less than 512 KiB left, so all subscribers get their samples by UDP";
static_assert(kSharedRoomBytes == 512 * 1024, "kNoRoom says so");
/// Maximum size of profiles in bytes.
constexpr std::size_t kMaxProfiles = 1U << 20;

/// Paths to inherited descriptors, for Fast DDS to open: the files themselves may belong to another user.
DdsSecurity security_of(int first) {
  const auto name = [first](int file) { return "/proc/self/fd/" + std::to_string(first + file); };
  return {name(0), name(1), name(2), name(3), name(4), name(5)};
}

/// Content of a file. A file longer than allowed is truncated, so that it is not valid XML any more.
std::string content_of(int descriptor) {
  std::string content(kMaxProfiles, '\0');
  std::size_t length = 0;
  while (length < content.size()) {
    const auto more = ::pread(descriptor, content.data() + length, content.size() - length, static_cast<off_t>(length));
    if (more <= 0) break;
    length += static_cast<std::size_t>(more);
  }
  content.resize(length);
  return content;
}

snapshot::Percentiles percentiles_of(const std::array<std::int64_t, 3>& from) {
  using std::chrono::nanoseconds;
  return {nanoseconds{from[0]}, nanoseconds{from[1]}, nanoseconds{from[2]}};
}

snapshot::LineStatus line_status(const snapshot::FeedStatus& from, std::int64_t period_ns) {
  const bool known = from.state <= static_cast<std::uint8_t>(snapshot::LineState::kOp);
  snapshot::LineStatus status;
  status.state = known ? static_cast<snapshot::LineState>(from.state) : snapshot::LineState::kDown;
  status.cycle_period = std::chrono::nanoseconds{period_ns};
  status.cycles = from.cycles;
  status.missed_periods = from.missed_periods;
  status.wkc_errors = from.wkc_errors;
  status.lost_frames = from.lost_frames;
  status.wake_latency = percentiles_of(from.wake_latency_ns);
  status.cycle_cost = percentiles_of(from.cycle_cost_ns);
  status.statistics = from.statistics;
  for (std::uint16_t i = 0; i < from.faults; ++i) status.faults.emplace_back(from.fault[i].view());
  return status;
}

}  // namespace

std::string Bridge::set_up() {
  std::optional<std::uint64_t> from;
  if (options_.counts >= 0) {
    auto opened = snapshot::FeedReturnWriter::open(options_.counts);
    if (!opened) return describe(opened.error());
    return_.emplace(*std::move(opened));
    earlier_return_ = return_->last_record();
    from = earlier_return_.next;
  }
  auto opened =
      snapshot::FeedReader::open(options_.feed, options_.feed + 1, options_.feed + 2, options_.feed + 3, from);
  if (!opened) return describe(opened.error());
  feed_.emplace(*std::move(opened));
  const auto& description = feed_->description();
  if (options_.condition >= 0) {
    auto condition = snapshot::FeedConditionReader::open(options_.condition, description.slaves, description.axes);
    if (!condition) return describe(condition.error());
    condition_.emplace(*std::move(condition));
  }
  if (options_.user && ::geteuid() != 0 && ::geteuid() != options_.user->user) {
    return "only root can change to user " + std::to_string(options_.user->user);
  }
  if (auto wrong = give_up_privileges(description.realtime_cpu, options_.user.value_or(Identity{})); !wrong.empty()) {
    return wrong;
  }
  // After the change of user, which resets this setting.
  if (options_.supervisor >= 0) ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  bool shared_memory = description.shared_memory != 0;
  if (shared_memory) {
    files_ = limit_files_to_shared_memory();
    remove_stale_segments();
    shared_memory = shared_memory_has_room();
    no_room_ = !shared_memory;
  }
  auto config = config_of(description);
  config.shared_memory = shared_memory;
  if (options_.security >= 0) config.security = security_of(options_.security);
  if (options_.qos >= 0) config.profiles = {content_of(options_.qos), options_.qos_file};
  auto publisher = DdsPublisher::create(std::move(config));
  if (!publisher) return describe(publisher.error());
  publisher_ = *std::move(publisher);
  if (options_.commands >= 0) {
    auto relay = CommandRelay::open(options_.commands, *publisher_);
    if (!relay) return describe(relay.error());
    commands_ = *std::move(relay);
  }
  return filter_system_calls(shared_memory);
}

std::string Bridge::run() {
  if (auto wrong = set_up(); !wrong.empty()) {
    say('F', wrong);
    return wrong;
  }
  const bool no_limits = files_ == FileLimits::kNone;
  say('R', no_room_ ? kNoRoom : no_limits ? kNoLimits : std::string_view{});
  bool more = false;
  bool ends = false;
  while (!ends && !stop_.load(std::memory_order_relaxed) && (more || status_.ended == 0)) {
    more = pass();
    if (!more) feed_->wait(kPause);
    ends = must_end();
  }
  ::alarm(kFarewellSeconds);
  while (pass()) continue;
  if (status_.ended == 0) end_without_line();
  publisher_->finish(counters_);
  tell();
  return {};
}

/// Returns true if there is more to do.
bool Bridge::pass() {
  take_status();
  take_events();
  take_condition();
  if (commands_) commands_->serve();
  int taken = 0;
  for (; taken < kCyclesPerPass && feed_->take(); ++taken) {
    if (const auto* line = feed_->line()) publisher_->lines({line, 1});
    publisher_->axes(feed_->axes());
  }
  counters_.lines_dropped = feed_->lost();
  counters_.axes_dropped = feed_->lost() * feed_->description().axes;
  publisher_->pass_done(counters_);
  tell();
  return taken == kCyclesPerPass;
}

void Bridge::take_status() {
  snapshot::FeedStatus status;
  if (!feed_->status(status)) return;
  const auto now = std::chrono::steady_clock::now();
  if (status.beats != status_.beats || beats_ == 0) line_alive_at_ = now;
  publisher_->set_stalled(status.ended == 0 && now - line_alive_at_ > kStandsStill);
  if (std::memcmp(&status, &status_, sizeof(status)) == 0 && beats_ > 0) return;
  status_ = status;
  publisher_->set_earlier({.published = status.published_before, .dropped = status.dropped_before});
  publisher_->set_line_status(line_status(status, feed_->description().period_ns));
}

void Bridge::take_events() {
  snapshot::FeedEvent event;
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < snapshot::kFeedEvents && feed_->take_event(event, number); ++i) {
    const auto severity =
        std::min<std::uint64_t>(event.severity, static_cast<std::uint64_t>(DdsEventSeverity::kFailure));
    publisher_->event({.number = number,
                       .wall_time_ns = event.wall_time_ns,
                       .severity = static_cast<DdsEventSeverity>(severity),
                       .text = std::string{event.text.view()}});
  }
}

void Bridge::take_condition() {
  snapshot::FeedCondition condition;
  if (condition_ && condition_->take(condition)) publisher_->set_condition(condition);
}

void Bridge::tell() {
  ++beats_;
  if (!return_) return;
  const auto own = publisher_->counters();
  const auto refused = own.dropped - counters_.lines_dropped - counters_.axes_dropped;
  return_->tell({.beats = earlier_return_.beats + beats_,
                 .next = feed_->next(),
                 .published = earlier_return_.published + own.published,
                 .lost = earlier_return_.lost + feed_->lost(),
                 .refused = earlier_return_.refused + refused});
}

/// Whether the supervisor has closed its side of the socket; it never sends anything.
bool Bridge::must_end() const {
  pollfd waiting{options_.supervisor, POLLIN, 0};  // poll() ignores a negative descriptor
  if (::poll(&waiting, 1, 0) <= 0) return false;
  char ignored = 0;
  const auto length = ::recv(options_.supervisor, &ignored, sizeof(ignored), MSG_DONTWAIT);
  return length == 0 || (length < 0 && errno != EAGAIN && errno != EINTR);
}

/// The process of the line ended without a final status: publish one to the subscribers.
void Bridge::end_without_line() {
  auto status = line_status(status_, feed_->description().period_ns);
  status.state = snapshot::LineState::kDown;
  status.faults.emplace_back("the process of the line has ended, or its telemetry was stopped");
  publisher_->set_line_status(status);
}

void Bridge::say(char kind, std::string_view text) const {
  if (options_.supervisor < 0) return;
  std::string message{kind};
  message += text.substr(0, kLongestMessage);
  static_cast<void>(::send(options_.supervisor, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
}

}  // namespace driveline::bridge
