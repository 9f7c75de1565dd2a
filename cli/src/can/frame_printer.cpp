#include "can/frame_printer.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "text/visible_text.hpp"

namespace driveline::cli {
namespace {

using canopen::FrameKind;

double seconds_since(std::chrono::nanoseconds start, std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time - start).count();
}

std::string_view kind_word(FrameKind kind) {
  switch (kind) {
    case FrameKind::kData:
      return "data";
    case FrameKind::kRemote:
      return "remote";
    case FrameKind::kError:
      return "error";
  }
  return "";
}

/// Bytes, or what stands for them.
std::string content_words(const canopen::Frame& frame) {
  return frame.kind == FrameKind::kRemote ? std::string("remote request") : bytes_words(frame.payload());
}

}  // namespace

std::string identifier_words(const canopen::Identifier& identifier) {
  return identifier.extended ? fmt::format("{:08X}", identifier.value) : fmt::format("{:03X}", identifier.value);
}

std::string frame_line(const canopen::ReceivedFrame& received, std::chrono::nanoseconds start,
                       const FrameWords& words) {
  const auto& frame = received.frame;
  const bool error = frame.kind == FrameKind::kError;
  auto line =
      fmt::format("{:12.6f}  {:>8}  {}  {:<23}  {:<20}  {}", seconds_since(start, received.time),
                  error ? "" : identifier_words(frame.identifier), error ? " " : fmt::format("{}", frame.length),
                  content_words(frame), words.name, words.meaning);
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string frame_json_line(const canopen::ReceivedFrame& received, std::chrono::nanoseconds start,
                            const FrameWords& words) {
  const auto& frame = received.frame;
  nlohmann::json document = {{"time_s", seconds_since(start, received.time)},
                             {"identifier", frame.identifier.value},
                             {"extended", frame.identifier.extended},
                             {"kind", kind_word(frame.kind)},
                             {"length", frame.length},
                             {"data", bytes_words(frame.payload())},
                             {"name", words.name},
                             {"node", nullptr},
                             {"meaning", words.meaning}};
  if (words.node != 0) document["node"] = words.node;
  return visible_json(document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) + "\n";
}

void FramePrinter::print(const canopen::ReceivedFrame& received) {
  const auto words = reader_.read(received.frame);
  print_text(json_ ? frame_json_line(received, start_, words) : frame_line(received, start_, words));
  ++count_;
  if (received.frame.kind != FrameKind::kError) bits_ += canopen::bit_count(received.frame);
}

}  // namespace driveline::cli
