#include "line/run_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "axes/axis_words.hpp"
#include "commands/command_input.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/motion/drive/drive_objects.hpp"

namespace driveline::cli {
namespace {

using ecat_master::CoeClient;
using ecat_master::Master;
using ecat_master::SdoAddress;
using nlohmann::json;

constexpr std::string_view kError = "error: ";

std::string error(std::string_view text) {
  return fmt::format("{}{}", kError, text);
}

template <typename Number>
std::optional<Number> whole(std::string_view text, int base) {
  Number value{};
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (wrong != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Parses "0x6041:0".
std::optional<SdoAddress> address_in(std::string_view text) {
  if (!text.starts_with("0x")) return std::nullopt;
  text.remove_prefix(2);
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto index = whole<std::uint16_t>(text.substr(0, colon), 16);
  const auto subindex = whole<std::uint8_t>(text.substr(colon + 1), 10);
  if (!index || !subindex) return std::nullopt;
  return SdoAddress{*index, *subindex};
}

std::string hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{:02x}", std::to_integer<unsigned>(byte));
  return text;
}

std::vector<std::byte> bytes_of(std::string_view text) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(whole<std::uint8_t>(text.substr(i, 2), 16).value_or(0)));
  }
  return bytes;
}

std::string answer_slaves(const Master& master) {
  auto aliases = json::array();
  for (const auto& slave : master.slaves()) aliases.push_back(slave.info.alias);
  return json{{"aliases", std::move(aliases)}}.dump();
}

std::string acknowledge_fault(Master& master, std::size_t slave) {
  const auto done = CoeClient(*master.mailbox(slave)).download_as<std::uint8_t>(kFaultResetIndex, 0, 1);
  if (done) return "{}";
  if (never_served(done.error())) return error(no_fault_reset(slave).value().text);
  return error(ecat_master::describe(done.error()));
}

/// The bytes as text; null: the object is not available now; false: it never is.
ecat_master::Result<json> upload(CoeClient& coe, const SdoAddress& at) {
  const auto data = coe.upload(at.index, at.subindex);
  if (data) return json(hex(*data));
  if (never_served(data.error())) return json(false);
  if (data.error().is<ecat_master::facts::SdoAbort>()) return json();
  return tl::unexpected(data.error());
}

std::string answer_objects(Master& master, std::size_t slave, std::span<const std::string> words) {
  auto diagnosis = ecat_master::read_slave_diagnosis(master.bus(), std::span(&master.slaves()[slave], 1));
  if (!diagnosis) return error(ecat_master::describe(diagnosis.error()));
  const auto& state = diagnosis->front();
  if (!state.answers) return error(fmt::format("slave {} does not answer", slave));
  auto ports = json::array();
  for (const auto& port : state.ports) ports.push_back({port.status.link, port.status.communication});
  json answer = {{"al", state.al.status.raw()},
                 {"code", static_cast<unsigned>(state.al.code)},
                 {"ports", std::move(ports)},
                 {"values", json::array()}};
  CoeClient coe(*master.mailbox(slave));
  for (const auto& word : words) {
    const auto at = address_in(word);
    if (!at) return error(fmt::format("drive: \"{}\": an object such as 0x6041:0 is expected", word));
    auto value = upload(coe, *at);
    if (!value) return error(ecat_master::describe(value.error()));
    answer["values"].push_back(std::move(*value));
  }
  return answer.dump();
}

Outcome<json> ask(const std::string& control, const std::string& words) {
  const auto answer = send_command(control, "drive " + words, "run");
  if (!answer) return tl::unexpected(answer.error());
  if (answer->starts_with(kError)) return failed(answer->substr(kError.size()));
  auto document = json::parse(*answer, nullptr, false);
  if (!document.is_object()) return failed(*answer);
  return document;
}

void take_state(const json& answer, DriveView& view) {
  view.al.status = wire::AlStatus::from_raw(answer.at("al").get<std::uint16_t>());
  view.al.code = static_cast<wire::AlStatusCode>(answer.at("code").get<std::uint16_t>());
  const auto& ports = answer.at("ports");
  for (std::size_t i = 0; i < std::min(ports.size(), view.dl.ports.size()); ++i) {
    view.dl.ports.at(i).link = ports.at(i).at(0).get<bool>();
    view.dl.ports.at(i).communication = ports.at(i).at(1).get<bool>();
  }
}

}  // namespace

std::string answer_about_drives(runtime::Line& line, std::string_view words) {
  auto* const master = line.master();
  if (master == nullptr) return error("the line is not in operation");
  const auto split = split_words(words);
  if (split.size() == 1 && split[0] == "slaves") return answer_slaves(*master);
  const auto slave = split.empty() ? std::nullopt : whole<std::size_t>(split[0], 10);
  if (!slave || *slave >= master->slaves().size() || split.size() < 2 || split.size() > 1 + kDriveObjectsAtOnce)
    return error(fmt::format("drive: the position of a slave and up to {} objects are expected", kDriveObjectsAtOnce));
  if (!master->slaves()[*slave].present) return error(fmt::format("slave {} does not answer", *slave));
  if (master->mailbox(*slave) == nullptr) return error(fmt::format("slave {} has no mailbox", *slave));
  if (split[1] == "acknowledge") return acknowledge_fault(*master, *slave);
  return answer_objects(*master, *slave, std::span(split).subspan(1));
}

Outcome<std::unique_ptr<RunDrives>> RunDrives::open(std::string control) {
  std::unique_ptr<RunDrives> drives(new RunDrives(std::move(control)));
  const auto answer = ask(drives->control_, "slaves");
  if (!answer) return tl::unexpected(answer.error());
  drives->aliases_ = answer->at("aliases").get<std::vector<std::uint16_t>>();
  return drives;
}

Outcome<void> RunDrives::read(std::size_t position, DriveView& view) {
  if (view.position != position) view.values = {};
  view.position = position;
  view.slaves = size();
  view.other_master = false;  // the master of the run itself reads the objects
  auto done = read_objects(position, view);
  if (done) done = check_device_type(position, view.values);
  view.trouble = done ? std::string{} : done.error().text;
  return done;
}

Outcome<void> RunDrives::read_objects(std::size_t position, DriveView& view) {
  const bool fresh = !view.values.bits(DriveObject::kDeviceType);
  auto& missing = missing_[position];
  std::vector<const DriveObjectRow*> rows;
  for (const auto& row : drive_objects()) {
    const bool known = row.constant && !fresh;
    if (!known && std::find(missing.begin(), missing.end(), row.object) == missing.end()) rows.push_back(&row);
  }
  for (std::size_t first = 0; first < rows.size(); first += kDriveObjectsAtOnce) {
    const auto part = std::span(rows).subspan(first, std::min(kDriveObjectsAtOnce, rows.size() - first));
    auto words = fmt::format("{}", position);
    for (const auto* row : part) {
      words += fmt::format(" 0x{:04X}:{}", motion::object_of_drive(row->index, view.drive), row->subindex);
    }
    const auto answer = ask(control_, words);
    if (!answer) return tl::unexpected(answer.error());
    take_state(*answer, view);
    const auto& values = answer->at("values");
    for (std::size_t i = 0; i < part.size(); ++i) {
      const auto& value = values.at(i);
      if (value.is_boolean()) missing.push_back(part[i]->object);
      view.values.set(part[i]->object,
                      value.is_string() ? std::optional(bytes_of(value.get<std::string>())) : std::nullopt);
    }
  }
  return {};
}

Outcome<void> RunDrives::acknowledge(std::size_t position) {
  const auto done = ask(control_, fmt::format("{} acknowledge", position));
  return done ? Outcome<void>{} : tl::unexpected(done.error());
}

}  // namespace driveline::cli
