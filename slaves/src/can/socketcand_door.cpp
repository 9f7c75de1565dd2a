#include "driveline/slaves/can/socketcand_door.hpp"

#include <utility>

#include "driveline/canopen_wire/socketcand.hpp"

namespace driveline::slaves::can {

SocketcandDoor::SocketcandDoor(std::string bus, nanoseconds epoch) : bus_(std::move(bus)), epoch_(epoch) {
  element_.reserve(kLongestElement);
}

void SocketcandDoor::restart() {
  mode_ = Mode::kNoBus;
  inside_ = false;
  answer("< hi >");
}

void SocketcandDoor::input(std::string_view bytes, nanoseconds /*now*/) {
  for (const char c : bytes) {
    if (closing()) return;
    if (c == '<') {
      inside_ = true;
      element_.clear();
    } else if (inside_ && c == '>') {
      inside_ = false;
      execute();
    } else if (inside_) {
      element_ += c;
      if (element_.size() < kLongestElement) continue;
      inside_ = false;
      fail("command too long");
    }
  }
}

void SocketcandDoor::execute() {
  std::string_view words = element_;
  const auto command = canopen::next_word(words);
  if (command == "echo") return answer("< echo >");
  if (command == "open") return open_bus(canopen::next_word(words));
  if (mode_ == Mode::kNoBus) return fail("no bus is open");
  if (command == "rawmode") return change_mode(Mode::kRaw);
  if (command == "bcmmode") return change_mode(Mode::kBroadcastManager);
  if (command == "send") return transmit(canopen::FrameKind::kData, words);
  if (command == "sendrtr") return transmit(canopen::FrameKind::kRemote, words);
  fail("unknown command");
}

/// A client that asks for a bus that is not there is sent away, as the daemon does it.
void SocketcandDoor::open_bus(std::string_view name) {
  if (mode_ != Mode::kNoBus) return fail("a bus is open already");
  if (name != bus_) {
    fail("could not open bus");
    return close();
  }
  controller().set_power(true);
  change_mode(Mode::kBroadcastManager);
}

void SocketcandDoor::change_mode(Mode mode) {
  mode_ = mode;
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
  if (mode_ != Mode::kRaw) return;
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(epoch_ + now);
  pass_on(canopen::socketcand::element_of(frame, static_cast<std::uint64_t>(time.count())).view());
}

}  // namespace driveline::slaves::can
