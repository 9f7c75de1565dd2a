#include "driveline/canopen_port/slcan_port.hpp"

#include <algorithm>
#include <utility>

#include "endpoints.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

/// An adapter that has been silent for so long has answered all that it was sent.
constexpr nanoseconds kQuiet = 50ms;
constexpr nanoseconds kLongQuiet = 500ms;
constexpr nanoseconds kFlagsInterval = 1s;

}  // namespace

tl::expected<std::unique_ptr<SlcanPort>, CanPortError> SlcanPort::open_terminal(const std::filesystem::path& path,
                                                                                const CanPortOptions& options,
                                                                                rt::Clock& clock) {
  auto descriptor = canopen::open_terminal(path);
  if (!descriptor) return tl::unexpected(descriptor.error());
  return on(std::move(*descriptor), path.string(), options, clock);
}

tl::expected<std::unique_ptr<SlcanPort>, CanPortError> SlcanPort::open_tcp(std::string_view address,
                                                                           const CanPortOptions& options,
                                                                           rt::Clock& clock) {
  auto descriptor = connect_tcp(address, kPatience);
  if (!descriptor) return tl::unexpected(descriptor.error());
  return on(std::move(*descriptor), address, options, clock);
}

tl::expected<std::unique_ptr<SlcanPort>, CanPortError> SlcanPort::on(rt::FileDescriptor descriptor,
                                                                     std::string_view place,
                                                                     const CanPortOptions& options, rt::Clock& clock,
                                                                     nanoseconds patience) {
  // Not make_unique: the constructor is not public.
  std::unique_ptr<SlcanPort> port{new SlcanPort{std::move(descriptor), options, clock}};
  if (auto started = port->start(place, patience); !started) return tl::unexpected(started.error());
  return port;
}

SlcanPort::~SlcanPort() {
  static_cast<void>(stream().write("C\r"));
}

/// An empty line ends half a line of an earlier program, and C closes a channel that it left open; a closed channel is
/// no error. From then on each command has one answer. If one is refused, it may have been the answer to something
/// earlier that has come late, so all is done again with more time.
tl::expected<void, CanPortError> SlcanPort::start(std::string_view place, nanoseconds patience) {
  const auto rate = slcan::bit_rate_command(options().bit_rate);
  if (rate.view().empty()) {
    return tl::unexpected(CanPortError{CanPortErrorCode::kUsage, "serial CAN adapters have no bit rate of " +
                                                                     std::to_string(options().bit_rate) + " bit/s."});
  }
  const std::string_view mode = options().listen_only ? "L" : "O";
  std::string_view last;
  Answer answer = Answer::kNone;
  const auto ask = [&](std::string_view text) {
    last = text;
    return answer = command(text, patience);
  };
  for (const nanoseconds quiet : {kQuiet, kLongQuiet}) {
    static_cast<void>(stream().write("\r"));
    let_finish(quiet);
    if (ask("C") == Answer::kNone) break;
    let_finish(quiet);
    if (ask(rate.view()) == Answer::kOk) ask(mode);
    if (answer != Answer::kRefused) break;
  }
  if (answer != Answer::kOk) return tl::unexpected(no_start(answer, last, place));
  next_flags_ = clock().now() + kFlagsInterval;
  return {};
}

CanPortError SlcanPort::no_start(Answer answer, std::string_view text, std::string_view place) {
  std::string message = "the serial CAN adapter at " + std::string(place);
  if (answer == Answer::kRefused) {
    message += " refuses the command " + std::string(text) + ".";
  } else if (stream().broken()) {
    message += " has gone away at the command " + std::string(text) + ".";
  } else {
    message += " does not answer the command " + std::string(text) + "; a carriage return or BEL was expected.";
  }
  return {CanPortErrorCode::kMachine, std::move(message)};
}

/// Reads until the adapter has been silent for `quiet`.
void SlcanPort::let_finish(nanoseconds quiet) noexcept {
  const nanoseconds end = clock().now() + 6 * quiet;  // a bus that is never silent is waited for no longer
  while (const auto byte = await_byte(std::min(clock().now() + quiet, end))) {
    static_cast<void>(reader_.take(*byte));
    if (clock().now() >= end) break;
  }
}

SlcanPort::Answer SlcanPort::command(std::string_view text, nanoseconds patience) noexcept {
  Text<16> line;
  line.add(text).add(slcan::kOk);
  if (!stream().write(line.view())) return Answer::kNone;
  const nanoseconds deadline = clock().now() + patience;
  while (const auto byte = await_byte(deadline)) {
    const auto event = reader_.take(*byte);
    if (event == SlcanReader::Event::kOk) return Answer::kOk;
    if (event == SlcanReader::Event::kRefused) return Answer::kRefused;
    if (clock().now() >= deadline) break;
  }
  return Answer::kNone;
}

std::optional<Frame> SlcanPort::take(char byte) noexcept {
  switch (reader_.take(byte)) {
    case SlcanReader::Event::kFrame:
      return reader_.frame();
    case SlcanReader::Event::kOk:
    case SlcanReader::Event::kSent:
      answered(true);
      break;
    case SlcanReader::Event::kRefused:
      answered(false);
      break;
    case SlcanReader::Event::kFlags:
      take_flags();
      break;
    case SlcanReader::Event::kNone:
      break;
  }
  return std::nullopt;
}

/// Answers come in the order of what they answer: frames before F, F, frames behind it.
void SlcanPort::answered(bool good) noexcept {
  if (unanswered_ > 0) {
    --unanswered_;
    if (!good) ++counters().lost;
  } else if (flags_pending_ && !good) {
    flags_pending_ = false;  // the adapter does not know F
    next_flags_ = kNever;
    unanswered_ = std::exchange(unanswered_behind_, 0);
  }
}

void SlcanPort::take_flags() noexcept {
  flags_pending_ = false;
  unanswered_ = std::exchange(unanswered_behind_, 0);
  const std::uint8_t flags = reader_.flags();
  if ((flags & slcan::status_flag::kDataOverrun) != 0) ++counters().lost;
  counters().state = (flags & slcan::status_flag::kErrorPassive) != 0   ? BusState::kErrorPassive
                     : (flags & slcan::status_flag::kErrorWarning) != 0 ? BusState::kErrorWarning
                                                                        : BusState::kErrorActive;
}

SendStatus SlcanPort::write_frame(const Frame& frame) noexcept {
  if (options().listen_only) return SendStatus::kNotValid;
  if (!stream().write(slcan::line_of(frame).view())) return SendStatus::kBusy;
  ++(flags_pending_ ? unanswered_behind_ : unanswered_);
  return SendStatus::kSent;
}

void SlcanPort::act(nanoseconds now) noexcept {
  if (now < next_flags_) return;
  if (flags_pending_) {  // nor does an adapter that says nothing
    flags_pending_ = false;
    next_flags_ = kNever;
    unanswered_ += std::exchange(unanswered_behind_, 0);
    return;
  }
  next_flags_ = now + kFlagsInterval;
  flags_pending_ = stream().write("F\r");
}

}  // namespace driveline::canopen
