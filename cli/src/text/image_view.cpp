#include "text/image_view.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace driveline::cli {
namespace {

using ecat_master::Master;
using ecat_master::ProcessDataPlace;
using ecat_master::ProcessImage;

double us(std::chrono::nanoseconds time) {
  return static_cast<double>(time.count()) / 1000.0;
}

std::string rhythm(const ecat_master::ExchangeGroupSettings& settings) {
  if (settings.divider == 1) return "every cycle";
  return fmt::format("every {} cycles from {}", settings.divider, settings.phase);
}

std::string wire_text(const runtime::WireBudget& wire) {
  return fmt::format(
      "    busiest cycle      {:.1f} us of {:.1f} us on the wire, {:.1f} %:\n"
      "                       frames {:.1f} us, line {:.1f} us ({})\n"
      "    acyclic frames     {} bytes a cycle\n",
      us(wire.total()), us(wire.period), 100.0 * wire.utilisation(), us(wire.frames), us(wire.line),
      wire.line_measured ? "measured" : "assumed", wire.acyclic_bytes);
}

/// The position of the bytes that a slave has in one direction; "-": it has none.
std::string range_text(std::size_t datagram, std::size_t offset, std::size_t bytes) {
  if (datagram == ProcessDataPlace::kNone || bytes == 0) return "-";
  return fmt::format("0x{:08X} {:>4} B", ProcessImage::logical_address(offset), bytes);
}

std::string status_text(const ProcessDataPlace& place) {
  std::string text;
  if (place.al_status_offset != ProcessDataPlace::kNone) text = "AL";
  if (place.mailbox_offset != ProcessDataPlace::kNone) text += text.empty() ? "mailbox" : ", mailbox";
  return text.empty() ? "-" : text;
}

std::string slave_rows(const runtime::LineConfig& config, const Master& master) {
  std::string text = fmt::format("{:>4}  {:<10}  {:<8}  {:<17}  {:<17}  {}\n", "pos", "slave", "group", "outputs",
                                 "inputs", "status bytes");
  for (const auto& slave : master.slaves()) {
    const auto& place = master.image().places()[slave.info.ref.position];
    text += fmt::format("{:>4}  {:<10}  {:<8}  {:<17}  {:<17}  {}\n", slave.info.ref.position, slave.plan.name,
                        runtime::group_name(config, place.group),
                        range_text(place.output_datagram, place.output_offset, place.output_bytes),
                        range_text(place.input_datagram, place.input_offset, place.input_bytes), status_text(place));
  }
  return text;
}

std::string entry_rows(const runtime::NamedProcessData& named) {
  std::string text = fmt::format("{:<13}  {:>4}  {:<3}  {:<9}  {}\n", "address.bit", "bits", "", "object", "name");
  for (const auto& variable : named.variables.all()) {
    text += fmt::format("0x{:08X}.{}   {:>4}  {:<3}  {:04X}h:{:02X}  {}\n",
                        ProcessImage::logical_address(variable.bit_offset / 8), variable.bit_offset % 8, variable.bits,
                        variable.output ? "out" : "in", variable.index, variable.subindex,
                        named.variables.full_name(variable));
  }
  return text;
}

std::string datagram_rows(const runtime::LineConfig& config, const Master& master) {
  std::string text;
  for (const auto& datagram : master.image().datagrams()) {
    text += fmt::format("frame {}  {}  0x{:08X}  {:>4} B  WKC {:>3}  group {}\n", datagram.frame,
                        wire::to_text(datagram.command), ProcessImage::logical_address(datagram.offset), datagram.bytes,
                        datagram.expected_working_counter, runtime::group_name(config, datagram.group));
  }
  return text;
}

}  // namespace

std::string to_text(const runtime::ImageView& view) {
  std::string text = fmt::format("  process data: {}, {} bytes, {} datagram(s) in {} frame(s)\n{}", view.layout,
                                 view.bytes, view.datagrams, view.frames, wire_text(view.wire));
  for (const auto& group : view.groups) {
    // A group without datagrams is never exchanged.
    if (group.datagrams == 0) {
      text += fmt::format("    group {:<12} {}, no process data\n", group.name, rhythm(group.settings));
      continue;
    }
    text += fmt::format("    group {:<12} {}, {} slave(s), frame(s) {}, WKC {}", group.name, rhythm(group.settings),
                        group.slaves, fmt::join(group.frames, ", "), group.working_counter);
    if (group.exchanges > 0) {
      text += fmt::format("\n      {} exchanges, {} frames lost, {} WKC errors, at most {} in a row", group.exchanges,
                          group.lost_frames, group.wkc_errors, group.longest_bad);
    }
    if (group.settings.bad_cycle_limit > 0) {
      text +=
          fmt::format("\n      outputs zero after {} bad, {} time(s)", group.settings.bad_cycle_limit, group.zeroings);
    }
    text += '\n';
  }
  return text;
}

nlohmann::json to_json(const runtime::ImageView& view) {
  auto groups = nlohmann::json::array();
  for (const auto& group : view.groups) {
    groups.push_back({{"name", group.name},
                      {"divider", group.settings.divider},
                      {"phase", group.settings.phase},
                      {"zero_outputs_after", group.settings.bad_cycle_limit},
                      {"slaves", group.slaves},
                      {"datagrams", group.datagrams},
                      {"frames", group.frames},
                      {"working_counter", group.working_counter},
                      {"exchanges", group.exchanges},
                      {"lost_frames", group.lost_frames},
                      {"wkc_errors", group.wkc_errors},
                      {"longest_bad", group.longest_bad},
                      {"zeroings", group.zeroings}});
  }
  return {{"layout", view.layout},
          {"bytes", view.bytes},
          {"datagrams", view.datagrams},
          {"frames", view.frames},
          {"wire_frames_ns", view.wire.frames.count()},
          {"wire_line_ns", view.wire.line.count()},
          {"wire_line_measured", view.wire.line_measured},
          {"wire_time_ns", view.wire.total().count()},
          {"wire_utilisation", view.wire.utilisation()},
          {"acyclic_bytes", view.wire.acyclic_bytes},
          {"groups", groups}};
}

std::string image_text(const runtime::LineConfig& config, const Master& master,
                       const runtime::NamedProcessData& named) {
  std::string text = to_text(runtime::view_image(config, master)) + "\n" + slave_rows(config, master) + "\n" +
                     entry_rows(named) + "\n" + datagram_rows(config, master);
  for (std::size_t i = 0; i < named.copies.size(); ++i) {
    const auto& copy = named.copies[i];
    text += fmt::format("copy    {} -> {}, {} bits\n", config.process_data.copies[i].from,
                        config.process_data.copies[i].to, copy.bits);
  }
  return text;
}

nlohmann::json image_json(const runtime::LineConfig& config, const Master& master,
                          const runtime::NamedProcessData& named) {
  auto document = to_json(runtime::view_image(config, master));
  auto slaves = nlohmann::json::array();
  for (const auto& slave : master.slaves()) {
    const auto& place = master.image().places()[slave.info.ref.position];
    const auto address = [](std::size_t datagram, std::size_t offset) {
      return datagram == ProcessDataPlace::kNone ? nlohmann::json(nullptr)
                                                 : nlohmann::json(ProcessImage::logical_address(offset));
    };
    slaves.push_back({{"position", slave.info.ref.position},
                      {"name", slave.plan.name},
                      {"group", runtime::group_name(config, place.group)},
                      {"output_address", address(place.output_datagram, place.output_offset)},
                      {"output_bytes", place.output_bytes},
                      {"input_address", address(place.input_datagram, place.input_offset)},
                      {"input_bytes", place.input_bytes}});
  }
  auto entries = nlohmann::json::array();
  for (const auto& variable : named.variables.all()) {
    entries.push_back({{"name", named.variables.full_name(variable)},
                       {"index", variable.index},
                       {"subindex", variable.subindex},
                       {"output", variable.output},
                       {"address", ProcessImage::logical_address(variable.bit_offset / 8)},
                       {"bit", variable.bit_offset % 8},
                       {"bits", variable.bits}});
  }
  auto datagrams = nlohmann::json::array();
  for (const auto& datagram : master.image().datagrams()) {
    datagrams.push_back({{"frame", datagram.frame},
                         {"command", wire::to_text(datagram.command)},
                         {"address", ProcessImage::logical_address(datagram.offset)},
                         {"bytes", datagram.bytes},
                         {"working_counter", datagram.expected_working_counter},
                         {"group", runtime::group_name(config, datagram.group)}});
  }
  auto copies = nlohmann::json::array();
  for (std::size_t i = 0; i < named.copies.size(); ++i) {
    copies.push_back({{"from", config.process_data.copies[i].from},
                      {"to", config.process_data.copies[i].to},
                      {"bits", named.copies[i].bits}});
  }
  document["slaves"] = std::move(slaves);
  document["entries"] = std::move(entries);
  document["datagram_list"] = std::move(datagrams);
  document["copies"] = std::move(copies);
  return document;
}

}  // namespace driveline::cli
