#include "driveline/canopen_port/slcan_reader.hpp"

namespace driveline::canopen {

SlcanReader::Event SlcanReader::take(char character) noexcept {
  if (character == slcan::kOk) {
    const Event event = too_long_ ? Event::kNone : line();
    line_ = {};
    too_long_ = false;
    return event;
  }
  if (character == slcan::kError) {
    // The answer stands for itself: what is before it is half a line.
    if (!line_.view().empty() && !too_long_) ++malformed_;
    line_ = {};
    too_long_ = false;
    return Event::kRefused;
  }
  if (character == '\n' || too_long_) return Event::kNone;  // some adapters end lines with both
  if (line_.view().size() == kLongestLine) {
    too_long_ = true;
    ++malformed_;
  }
  line_.add(character);
  return Event::kNone;
}

SlcanReader::Event SlcanReader::line() noexcept {
  const std::string_view text = line_.view();
  if (text.empty()) return Event::kOk;
  if (text == "z" || text == "Z") return Event::kSent;
  if (text.front() == 'V' || text.front() == 'v' || text.front() == 'N') return Event::kNone;  // version, serial number
  if (text.front() == 'F' && text.size() == 3) {
    if (const auto flags = hex_number(text.substr(1))) {
      flags_ = static_cast<std::uint8_t>(*flags);
      return Event::kFlags;
    }
  }
  if (const auto stamped = slcan::parse_line(text)) {
    frame_ = stamped->frame;
    return Event::kFrame;
  }
  ++malformed_;
  return Event::kNone;
}

}  // namespace driveline::canopen
