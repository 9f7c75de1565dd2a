#include "telemetry/bridge_supervisor.hpp"

#include "driveline/runtime/event.hpp"

#include <poll.h>

#include <cstddef>
#include <thread>
#include <utility>

namespace driveline::runtime {
namespace {

/// First letters of the messages of the bridge.
constexpr char kReady = 'R';
constexpr char kFailed = 'F';
/// Longest message that is read; a bridge sends only one or two.
constexpr std::size_t kLongestMessage = 512;
constexpr int kMessagesAtOnce = 4;
/// Time for the last samples; a subscriber that does not answer delays the bridge by a third of a second.
constexpr std::chrono::milliseconds kFarewell{3000};
constexpr int kStartPollMs = 5;
/// Time without a sign of life after which a bridge of a service counts as gone.
constexpr std::chrono::milliseconds kGone{1000};

/// Returns the text of the bridge, which may contain anything, as printable ASCII.
std::string printable(std::span<const std::byte> text) {
  std::string clean;
  for (const auto byte : text) {
    const auto letter = std::to_integer<unsigned char>(byte);
    clean += letter >= ' ' && letter < 0x7F ? static_cast<char>(letter) : ' ';
  }
  return clean;
}

}  // namespace

Result<std::unique_ptr<BridgeSupervisor>> BridgeSupervisor::create(const snapshot::FeedWriter& feed,
                                                                   Settings settings) {
  // The names differ, so that a bridge that is started manually next to the present one does not write its counts.
  const char* const name = settings.program.empty() ? "driveline-feed-service" : "driveline-feed-return";
  auto region = rt::SharedRegion::create(name, snapshot::feed_return_layout(1));
  if (!region) return fail(ErrorKind::kMachine, rt::describe(region.error()), "telemetry");
  return std::unique_ptr<BridgeSupervisor>(new BridgeSupervisor(feed, std::move(settings), *std::move(region)));
}

Result<void> BridgeSupervisor::spawn(Clock::time_point now) {
  counts_.begin(feed_.written());
  reason_.clear();
  running_ = false;
  still_ = false;
  invalid_counts_reported_ = false;
  beats_ = 0;
  alive_at_ = now;
  started_at_ = now;
  constexpr int kFeed = HelperProcess::kSocket + 1;
  std::vector<int> passed{feed_.description_descriptor(), feed_.status_descriptor(), feed_.cycles_descriptor(),
                          feed_.events_descriptor(), region_.descriptor()};
  std::vector<std::string> arguments{"--supervisor-fd", std::to_string(HelperProcess::kSocket),
                                     "--feed-fd",       std::to_string(kFeed),
                                     "--return-fd",     std::to_string(kFeed + 4)};
  const auto add = [&](const char* option, const std::vector<int>& descriptors) {
    if (descriptors.empty()) return;
    arguments.insert(arguments.end(), {option, std::to_string(HelperProcess::kSocket + 1 + passed.size())});
    passed.insert(passed.end(), descriptors.begin(), descriptors.end());
  };
  add("--condition-fd", {feed_.condition_descriptor()});
  add("--commands-fd", settings_.commands);
  add("--security-fd", settings_.security);
  if (settings_.qos_profiles >= 0) {
    add("--qos-fd", {settings_.qos_profiles});
    arguments.insert(arguments.end(), {"--qos-file", settings_.qos_file});
  }
  if (!settings_.user.empty()) arguments.insert(arguments.end(), {"--user", settings_.user});
  auto started = HelperProcess::start(settings_.program, std::move(arguments), passed);
  if (!started) return tl::unexpected(started.error());
  process_ = std::move(*started);
  return {};
}

Result<void> BridgeSupervisor::start() {
  auto now = Clock::now();
  if (by_service()) {
    counts_.begin(feed_.written());
    return {};
  }
  if (auto started = spawn(now); !started) return started;
  const auto limit = now + settings_.start_limit;
  while (process_.valid() && !running_ && now < limit) {
    pollfd waiting{process_.descriptor(), POLLIN, 0};
    static_cast<void>(::poll(&waiting, 1, kStartPollMs));
    now = Clock::now();
    take_messages(now);
    if (!reason_.empty()) return refused();
    if (const auto status = process_.reap()) ended(describe_end(*status), now);
  }
  return {};
}

/// Returns the failure that the bridge has reported. A reason that starts with the name of the QoS file, as passed to
/// the bridge, is an error of that file, which the user can correct.
tl::unexpected<Error> BridgeSupervisor::refused() const {
  const auto& name = settings_.qos_file;
  const auto file = printable(std::as_bytes(std::span(name)));
  const auto end = reason_.find(": ", file.size());
  if (file.empty() || !reason_.starts_with(file) || end == std::string::npos) {
    return fail(ErrorKind::kMachine, reason_, "telemetry");
  }
  auto sentence = reason_.substr(end + 2);
  if (sentence.ends_with('.')) sentence.pop_back();
  return fail(ErrorKind::kFile, std::move(sentence), name + reason_.substr(file.size(), end - file.size()));
}

void BridgeSupervisor::serve(Clock::time_point now) {
  if (by_service()) {
    poll_guest(now);
    return;
  }
  if (!process_.valid()) {
    if (now < again_at_) return;
    ++restarts_;
    if (const auto started = spawn(now); !started) ended(started.error().reason, now);
    return;
  }
  take_messages(now);
  update_counts(now);
  report_stillness(now);
  if (const auto status = process_.reap()) {
    ended(describe_end(*status), now);
    return;
  }
  if (now - alive_at_ > settings_.hang_limit) process_.kill();
}

void BridgeSupervisor::take_messages(Clock::time_point now) {
  std::array<std::byte, kLongestMessage> room;
  for (int i = 0; i < kMessagesAtOnce; ++i) {
    std::size_t length = 0;
    if (process_.receive(room, length) != HelperProcess::Transfer::kDone) return;
    const auto message = std::span<const std::byte>(room).first(std::min(length, room.size()));
    if (message[0] == std::byte{kFailed}) reason_ = printable(message.subspan(1));
    if (message[0] != std::byte{kReady} || running_) continue;
    running_ = true;
    alive_at_ = now;
    if (restarts_ > 0) events_.emplace_back(events::BridgeBack{process_.id()});
    if (message.size() > 1) events_.emplace_back(events::BridgeRemark{printable(message.subspan(1))});
  }
}

void BridgeSupervisor::update_counts(Clock::time_point now) {
  if (!counts_.update(feed_.written())) {
    ++invalid_counts_;
    if (!std::exchange(invalid_counts_reported_, true)) events_.emplace_back(events::InvalidBridgeCounts{});
    return;
  }
  if (std::exchange(beats_, counts_.beats()) == counts_.beats()) return;
  alive_at_ = now;
  if (std::exchange(still_, false)) events_.emplace_back(events::BridgeBack{process_.id()});
  if (now - started_at_ > settings_.proven) pause_.reset();
}

/// Reports a bridge that has published and shows no sign of life any more.
void BridgeSupervisor::report_stillness(Clock::time_point now) {
  const bool published = by_service() ? beats_ > 0 : running_;
  if (!published || still_ || now - alive_at_ <= settings_.still_limit) return;
  still_ = true;
  events_.emplace_back(events::BridgeStill{process_.id(), settings_.still_limit});
}

/// Checks a bridge of a service. Its counts continue where those of the previous one ended.
void BridgeSupervisor::poll_guest(Clock::time_point now) {
  update_counts(now);
  running_ = beats_ > 0 && now - alive_at_ < kGone;
  report_stillness(now);
}

/// Waits until the bridge of a service has published the remaining records; it ends itself.
void BridgeSupervisor::await_guest() {
  const auto limit = Clock::now() + kFarewell;
  for (auto now = Clock::now(); now < limit; now = Clock::now()) {
    poll_guest(now);
    if (!running_ || counts_.next() == feed_.written()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds{kStartPollMs});
  }
}

void BridgeSupervisor::ended(const std::string& how, Clock::time_point now) {
  running_ = false;
  const auto pause = pause_.next();
  again_at_ = now + pause;
  events_.emplace_back(events::BridgeStopped{how, reason_, pause});
}

void BridgeSupervisor::end() {
  if (process_.valid()) static_cast<void>(process_.end(kFarewell));
  if (by_service()) await_guest();
  running_ = false;
  counts_.end(feed_.written());
}

}  // namespace driveline::runtime
