#include "driveline/slaves/can/slcan_door.hpp"

#include "driveline/canopen_wire/slcan.hpp"

namespace driveline::slaves::can {
namespace {

namespace slcan = canopen::slcan;

constexpr std::string_view kVersion = "V1013\r";       // hardware 1.0, software 1.3
constexpr std::string_view kSerialNumber = "NDRVL\r";  // four letters or digits

/// Bits of the answer to F (CANUSB manual, command F).
namespace status_flag {
constexpr std::uint8_t kTransmitQueueFull = 0x02;
constexpr std::uint8_t kErrorWarning = 0x04;
constexpr std::uint8_t kDataOverrun = 0x08;
constexpr std::uint8_t kErrorPassive = 0x20;
constexpr std::uint8_t kBusError = 0x80;
}  // namespace status_flag

/// Whether a bit is a whole number of nanoseconds, as the bus needs it.
constexpr bool possible(std::uint32_t bit_rate) noexcept {
  return bit_rate > 0 && 1'000'000'000 % bit_rate == 0;
}

constexpr bool is_switch(std::string_view arguments) noexcept {
  return arguments == "0" || arguments == "1";
}

}  // namespace

void SlcanDoor::restart() {
  line_.clear();
  too_long_ = channel_open_ = time_stamps_ = false;
}

void SlcanDoor::input(std::string_view bytes, nanoseconds /*now*/) {
  for (const char c : bytes) {
    if (c == slcan::kOk) {
      execute();
    } else if (c != '\n') {  // some programs end lines with both
      too_long_ = too_long_ || line_.size() == kLongestLine;
      if (!too_long_) line_ += c;
    }
  }
}

void SlcanDoor::execute() {
  // An empty line does nothing: programs send some to end what the adapter may have got before.
  const Answer given = too_long_       ? Answer::kError
                       : line_.empty() ? Answer::kOk
                                       : obey(line_.front(), std::string_view(line_).substr(1));
  if (given == Answer::kOk) answer({&slcan::kOk, 1});
  if (given == Answer::kError) {
    refuse();
    answer({&slcan::kError, 1});
  }
  line_.clear();
  too_long_ = false;
}

SlcanDoor::Answer SlcanDoor::obey(char command, std::string_view arguments) {
  switch (command) {
    case 't':
    case 'T':
    case 'r':
    case 'R':
      return transmit();
    case 'S': {
      const bool digit = arguments.size() == 1 && arguments[0] >= '0' && arguments[0] <= '8';
      return digit ? set_bit_rate(slcan::kBitRates[static_cast<std::size_t>(arguments[0] - '0')]) : Answer::kError;
    }
    case 's': {
      const auto registers = arguments.size() == 4 ? canopen::hex_number(arguments) : std::nullopt;
      return registers ? set_bit_rate(slcan::bit_rate_of(static_cast<std::uint16_t>(*registers))) : Answer::kError;
    }
    case 'Z':
      if (channel_open_ || !is_switch(arguments)) return Answer::kError;
      time_stamps_ = arguments == "1";
      return Answer::kOk;
    case 'X':  // auto poll, which is always on
      return arguments == "1" ? Answer::kOk : Answer::kError;
    default:
      break;
  }
  if (!arguments.empty()) return Answer::kError;
  switch (command) {
    case 'O':
      return open_channel(false);
    case 'L':
      return open_channel(true);
    case 'C':
      return close_channel();
    case 'F':
      return status_flags();
    case 'V':
      answer(kVersion);
      return Answer::kGiven;
    case 'N':
      answer(kSerialNumber);
      return Answer::kGiven;
    default:
      return Answer::kError;
  }
}

SlcanDoor::Answer SlcanDoor::open_channel(bool listen_only) {
  if (channel_open_) return Answer::kError;
  channel_open_ = true;
  controller().set_listen_only(listen_only);
  controller().set_power(true);
  return Answer::kOk;
}

SlcanDoor::Answer SlcanDoor::close_channel() {
  if (!channel_open_) return Answer::kError;
  channel_open_ = false;
  controller().set_power(false);
  return Answer::kOk;
}

SlcanDoor::Answer SlcanDoor::set_bit_rate(std::uint32_t bit_rate) {
  if (channel_open_ || !possible(bit_rate)) return Answer::kError;
  controller().set_bit_rate(bit_rate);
  return Answer::kOk;
}

/// "z" and "Z" before the end of the answer tell that the frame waits for the bus (CANUSB manual, command t).
SlcanDoor::Answer SlcanDoor::transmit() {
  const auto stamped = slcan::parse_line(line_);
  if (!channel_open_ || !stamped || stamped->milliseconds || !send(stamped->frame)) return Answer::kError;
  answer(stamped->frame.identifier.extended ? "Z\r" : "z\r");
  return Answer::kGiven;
}

SlcanDoor::Answer SlcanDoor::status_flags() {
  if (!channel_open_) return Answer::kError;
  const ErrorCounters& errors = controller().errors();
  std::uint8_t flags = 0;
  const auto put = [&flags](std::uint8_t flag, bool on) { flags |= on ? flag : std::uint8_t{0}; };
  put(status_flag::kTransmitQueueFull, controller().queue().size() >= controller().options().queue_capacity);
  put(status_flag::kErrorWarning, errors.warning());
  put(status_flag::kDataOverrun, take_overrun());
  put(status_flag::kErrorPassive, errors.state() == ErrorState::kPassive);
  put(status_flag::kBusError, errors.state() == ErrorState::kBusOff);
  canopen::Text<4> text;
  answer(text.add('F').add_hex(flags, 2).add(slcan::kOk).view());
  return Answer::kGiven;
}

void SlcanDoor::receive(const Frame& frame, nanoseconds now) {
  std::optional<std::uint16_t> stamp;
  if (time_stamps_) {
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
    stamp = static_cast<std::uint16_t>(milliseconds % slcan::kTimeStampsPerRound);
  }
  pass_on(slcan::line_of(frame, stamp).view());
}

}  // namespace driveline::slaves::can
