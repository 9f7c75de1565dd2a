#include "can/bus_figures.hpp"

#include <fmt/format.h>

#include "can/frame_printer.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "text/can_report.hpp"

namespace driveline::cli {
namespace {

using canopen::FrameKind;

double seconds_of(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

double rate_of(std::uint64_t count, std::chrono::nanoseconds time) {
  return time.count() > 0 ? static_cast<double>(count) / seconds_of(time) : 0.0;
}

std::string adapter_words(const canopen::PortStatistics& adapter) {
  auto text = fmt::format("adapter: {}, {} error frames, {} lost, {} malformed", bus_state_text(adapter.state),
                          adapter.error_frames, adapter.lost, adapter.malformed);
  if (adapter.send_errors) text += fmt::format(", transmit error counter {}", *adapter.send_errors);
  if (adapter.receive_errors) text += fmt::format(", receive error counter {}", *adapter.receive_errors);
  return text;
}

nlohmann::json counter_json(const std::optional<std::uint8_t>& counter) {
  return counter ? nlohmann::json(*counter) : nlohmann::json();
}

}  // namespace

void BusFigures::add(const canopen::Frame& frame) {
  if (frame.kind == FrameKind::kError) return;
  const auto bits = canopen::bit_count(frame);
  auto& row = rows_[canopen::arbitration_field(frame)];
  row.last = frame;
  ++row.frames;
  row.bits += bits;
  // Boot-up messages and heartbeats share an identifier.
  row.name = reader_.read(frame).name;
  ++frames_;
  bits_ += bits;
}

double BusFigures::load(std::uint32_t bit_rate, std::chrono::nanoseconds time) const {
  return rate_of(bits_, time) / bit_rate;
}

std::string BusFigures::to_text(const std::string& bus, std::uint32_t bit_rate, std::chrono::nanoseconds time,
                                const canopen::PortStatistics& adapter) const {
  auto text = fmt::format("{} at {} kbit/s, {:.3f} s: {} frames, {:.1f} frames/s, bus load {:.2f} %\n{}\n", bus,
                          bit_rate / 1000, seconds_of(time), frames_, rate_of(frames_, time),
                          100.0 * load(bit_rate, time), adapter_words(adapter));
  if (rows_.empty()) return text;
  text += fmt::format("{:>10} {:>8} {:>10} {:>7}  {}\n", "identifier", "frames", "frames/s", "load %", "name");
  for (const auto& [field, row] : rows_) {
    text += fmt::format("{:>10} {:>8} {:>10.1f} {:>7.2f}  {}", identifier_words(row.last.identifier), row.frames,
                        rate_of(row.frames, time), 100.0 * rate_of(row.bits, time) / bit_rate, row.name);
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

nlohmann::json BusFigures::to_json(const std::string& bus, std::uint32_t bit_rate, std::chrono::nanoseconds time,
                                   const canopen::PortStatistics& adapter) const {
  auto list = nlohmann::json::array();
  for (const auto& [field, row] : rows_) {
    list.push_back({{"identifier", row.last.identifier.value},
                    {"extended", row.last.identifier.extended},
                    {"remote", row.last.kind == FrameKind::kRemote},
                    {"frames", row.frames},
                    {"bits", row.bits},
                    {"frames_per_s", rate_of(row.frames, time)},
                    {"bus_load", rate_of(row.bits, time) / bit_rate},
                    {"name", row.name}});
  }
  return {{"interface", bus},
          {"bit_rate", bit_rate},
          {"duration_s", seconds_of(time)},
          {"frames", frames_},
          {"bits", bits_},
          {"frames_per_s", rate_of(frames_, time)},
          {"bus_load", load(bit_rate, time)},
          {"error_frames", adapter.error_frames},
          {"lost", adapter.lost},
          {"malformed", adapter.malformed},
          {"state", bus_state_text(adapter.state)},
          {"send_errors", counter_json(adapter.send_errors)},
          {"receive_errors", counter_json(adapter.receive_errors)},
          {"identifiers", list}};
}

}  // namespace driveline::cli
