#include "driveline/slaves/can/socketcand_door.hpp"

#include <algorithm>
#include <utility>

#include "driveline/canopen_wire/socketcand.hpp"

namespace driveline::slaves::can {
namespace {

/// Elements that wait behind the answer to rawmode: more than a bus at 1 Mbit/s has frames meanwhile.
constexpr std::size_t kMostHeld = 1100;

/// Reads seconds and microseconds, each up to 10^9; empty for anything else.
std::optional<nanoseconds> take_interval(std::string_view& words) {
  constexpr std::uint64_t kMost = 1'000'000'000;
  const auto seconds = canopen::decimal_number(canopen::next_word(words));
  const auto microseconds = canopen::decimal_number(canopen::next_word(words));
  if (!seconds || !microseconds || *seconds > kMost || *microseconds > kMost) return std::nullopt;
  return std::chrono::seconds{*seconds} + std::chrono::microseconds{*microseconds};
}

/// Reads an identifier with nothing behind it.
std::optional<canopen::Identifier> only_identifier(std::string_view words) {
  const auto identifier = canopen::parse_identifier(canopen::next_word(words));
  return canopen::next_word(words).empty() ? identifier : std::nullopt;
}

}  // namespace

void SocketcandDoor::Traffic::count(const Frame& frame) noexcept {
  ++frames;
  bytes += frame.payload().size();
}

SocketcandDoor::SocketcandDoor(std::string bus, nanoseconds epoch) : bus_(std::move(bus)), epoch_(epoch) {
  element_.reserve(kLongestElement);
}

void SocketcandDoor::restart() {
  mode_ = Mode::kNoBus;
  inside_ = false;
  received_ = sent_ = {};
  answer("< hi >");
}

void SocketcandDoor::left() noexcept {
  jobs_.clear();
  held_.clear();
  quiet_until_ = statistics_at_ = kNever;
  statistics_interval_ = nanoseconds{0};
}

void SocketcandDoor::input(std::string_view bytes, nanoseconds now) {
  if (!bytes.empty()) release();
  for (const char c : bytes) {
    if (closing()) return;
    if (c == '<') {
      inside_ = true;
      element_.clear();
    } else if (inside_ && c == '>') {
      inside_ = false;
      execute(now);
    } else if (inside_) {
      element_ += c;
      if (element_.size() < kLongestElement) continue;
      inside_ = false;
      fail("command too long");
    }
  }
}

void SocketcandDoor::execute(nanoseconds now) {
  std::string_view words = element_;
  const auto command = canopen::next_word(words);
  if (command == "echo") return answer("< echo >");
  if (command == "open") return open_bus(canopen::next_word(words), now);
  if (mode_ == Mode::kNoBus) return fail("no bus is open");
  if (command == "rawmode") return change_mode(Mode::kRaw, now);
  if (command == "bcmmode") return change_mode(Mode::kBroadcastManager, now);
  if (command == "controlmode") return change_mode(Mode::kControl, now);
  if (command == "isotpmode") return fail("ISO-TP is not supported");
  if (mode_ == Mode::kControl) {
    return command == "statistics" ? set_statistics(words, now) : fail("unknown command");
  }
  if (command == "send") return transmit(canopen::FrameKind::kData, words);
  if (command == "sendrtr") return transmit(canopen::FrameKind::kRemote, words);
  if (mode_ != Mode::kBroadcastManager || !manage(command, words, now)) fail("unknown command");
}

/// Commands of the broadcast manager; false: it is none.
bool SocketcandDoor::manage(std::string_view command, std::string_view words, nanoseconds now) {
  if (command == "add") {
    add_job(words, now);
  } else if (command == "update") {
    const auto frame = canopen::socketcand::parse_command(canopen::FrameKind::kData, words);
    if (!frame) {
      fail("syntax error in update command");
    } else if (!jobs_.update(*frame)) {
      fail("no job has this identifier");
    }
  } else if (command == "delete" || command == "unsubscribe") {
    remove(words, command == "delete");
  } else if (command == "subscribe" || command == "filter") {
    subscribe(words, command == "filter");
  } else {
    return false;
  }
  return true;
}

void SocketcandDoor::add_job(std::string_view words, nanoseconds now) {
  const auto period = take_interval(words);
  const auto frame = canopen::socketcand::parse_command(canopen::FrameKind::kData, words);
  if (!period || !frame) return fail("syntax error in add command");
  if (period->count() == 0) return fail("the interval of a job is 0");
  if (!jobs_.add(*frame, *period, now)) fail("too many jobs");
}

void SocketcandDoor::subscribe(std::string_view words, bool filtered) {
  const auto interval = take_interval(words);
  if (filtered) {
    const auto mask = canopen::socketcand::parse_command(canopen::FrameKind::kData, words);
    if (!interval || !mask) return fail("syntax error in filter command");
    if (!jobs_.subscribe(mask->identifier, *interval, mask)) fail("too many subscriptions");
    return;
  }
  const auto identifier = only_identifier(words);
  if (!interval || !identifier) return fail("syntax error in subscribe command");
  if (!jobs_.subscribe(*identifier, *interval, {})) fail("too many subscriptions");
}

void SocketcandDoor::remove(std::string_view words, bool job) {
  const auto identifier = only_identifier(words);
  if (!identifier) return fail(job ? "syntax error in delete command" : "syntax error in unsubscribe command");
  if (job ? jobs_.remove(*identifier) : jobs_.unsubscribe(*identifier)) return;
  fail(job ? "no job has this identifier" : "no subscription has this identifier");
}

void SocketcandDoor::set_statistics(std::string_view words, nanoseconds now) {
  constexpr std::uint64_t kDay = 86'400'000;
  const auto interval = canopen::decimal_number(canopen::next_word(words));
  if (!interval || *interval > kDay || !canopen::next_word(words).empty()) {
    return fail("syntax error in statistics command");
  }
  statistics_at_ = kNever;
  if (*interval == 0) return;
  statistics_interval_ = std::max<nanoseconds>(std::chrono::milliseconds{*interval}, kShortestStatistics);
  statistics_at_ = now + statistics_interval_;
}

void SocketcandDoor::tell_statistics(nanoseconds now) {
  statistics_at_ = now + statistics_interval_;
  canopen::Text<100> text;
  text.add("< stat ").add_decimal(received_.bytes).add(' ').add_decimal(received_.frames);
  text.add(' ').add_decimal(sent_.bytes).add(' ').add_decimal(sent_.frames).add(" >");
  answer(text.view());
}

/// A client that asks for a bus that is not there is sent away, as the daemon does it.
void SocketcandDoor::open_bus(std::string_view name, nanoseconds now) {
  if (mode_ != Mode::kNoBus) return fail("a bus is open already");
  if (name != bus_) {
    fail("could not open bus");
    return close();
  }
  controller().set_power(true);
  change_mode(Mode::kBroadcastManager, now);
}

/// Jobs and subscriptions end with the mode that they belong to.
void SocketcandDoor::change_mode(Mode mode, nanoseconds now) {
  jobs_.clear();
  mode_ = mode;
  quiet_until_ = mode == Mode::kRaw ? now + kQuiet : kNever;
  answer("< ok >");
}

void SocketcandDoor::transmit(canopen::FrameKind kind, std::string_view words) {
  const auto frame = canopen::socketcand::parse_command(kind, words);
  if (!frame) return fail("syntax error in send command");
  static_cast<void>(send(*frame));  // counted; the protocol has no answer to a frame
}

void SocketcandDoor::fail(std::string_view reason) {
  refuse();
  canopen::Text<64> text;
  answer(text.add("< error ").add(reason).add(" >").view());
}

void SocketcandDoor::receive(const Frame& frame, nanoseconds now) {
  if (frame.valid()) received_.count(frame);
  if (mode_ == Mode::kRaw || (mode_ == Mode::kBroadcastManager && jobs_.wants(frame, now))) tell(frame, now);
}

void SocketcandDoor::transmitted(const Frame& frame, nanoseconds /*now*/) {
  sent_.count(frame);
}

void SocketcandDoor::tell(const Frame& frame, nanoseconds now) {
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(epoch_ + now);
  const auto element = canopen::socketcand::element_of(frame, static_cast<std::uint64_t>(time.count()));
  if (held_.size() == kMostHeld) release();
  if (quiet_until_ == kNever) {
    pass_on(element.view());
  } else {
    held_.emplace_back(element.view());
  }
}

void SocketcandDoor::release() {
  quiet_until_ = kNever;
  for (const auto& element : std::exchange(held_, {})) pass_on(element);
}

void SocketcandDoor::advance(nanoseconds now) {
  if (quiet_until_ <= now) release();
  while (const auto frame = jobs_.take_due(now)) static_cast<void>(send(*frame));
  while (const auto frame = jobs_.take_held(now)) tell(*frame, now);
  if (statistics_at_ <= now) tell_statistics(now);
}

nanoseconds SocketcandDoor::next_wake() const noexcept {
  return std::min({jobs_.next_wake(), quiet_until_, statistics_at_});
}

}  // namespace driveline::slaves::can
