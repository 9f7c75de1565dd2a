#include "driveline/canopen_port/socketcand_reader.hpp"

#include "driveline/canopen_wire/socketcan.hpp"

namespace driveline::canopen {

SocketcandReader::Event SocketcandReader::take(char character) noexcept {
  if (character == '<') {
    if (inside_) ++malformed_;  // the one before has no end
    inside_ = true;
    skipping_ = false;
    element_ = {};
    return Event::kNone;
  }
  if (!inside_) {
    constexpr std::string_view kBlanks = " \t\r\n";
    return kBlanks.find(character) != std::string_view::npos ? Event::kNone : skip();
  }
  if (character == '>') {
    inside_ = false;
    return element();
  }
  if (element_.view().size() == kLongestElement) {
    inside_ = false;
    return skip();
  }
  element_.add(character);
  return Event::kNone;
}

SocketcandReader::Event SocketcandReader::skip() noexcept {
  if (!skipping_) ++malformed_;
  skipping_ = true;
  return Event::kNone;
}

SocketcandReader::Event SocketcandReader::element() noexcept {
  std::string_view words = element_.view();
  const auto kind = next_word(words);
  if (kind == "frame" || kind == "rtr") {
    const auto frame = socketcand::parse_element(element_.view());
    if (frame) frame_ = *frame;
    if (frame) return Event::kFrame;
  }
  if (kind == "error") return error(words);
  if (kind == "hi") return Event::kGreeting;
  if (kind == "ok") return Event::kOk;
  if (kind == "echo" || kind == "stat") return Event::kNone;
  ++malformed_;
  return Event::kNone;
}

/// "< error data >" is an error frame with its classes as a number, from some servers with a time behind it; other
/// words are the reason of a refusal.
SocketcandReader::Event SocketcandReader::error(std::string_view words) noexcept {
  std::string_view rest = words;
  const auto number = hex_number(next_word(rest));
  const auto behind = next_word(rest);
  if (number && (behind.empty() || (behind.front() >= '0' && behind.front() <= '9'))) {
    error_classes_ = *number & ~socketcan::flag::kError;
    frame_ = Frame{{}, FrameKind::kError, 0, {}};
    return Event::kErrorFrame;
  }
  const auto begin = words.find_first_not_of(' ');
  const auto end = words.find_last_not_of(' ');
  reason_ = begin == std::string_view::npos ? std::string_view() : words.substr(begin, end - begin + 1);
  return Event::kFailure;
}

}  // namespace driveline::canopen
