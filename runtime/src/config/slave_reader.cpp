#include "config/slave_reader.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "config/bus_reader.hpp"
#include "config/clock_config.hpp"
#include "config/eoe_reader.hpp"
#include "config/process_data_reader.hpp"
#include "config/slave_device_reader.hpp"
#include "config/slave_plan_reader.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/runtime/config/persona_text.hpp"
#include "driveline/slaves/esc/sii_file.hpp"
#include "driveline/slaves/persona/persona_slave.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// Longest delay of a slave; a longer one would use up the cycle.
constexpr std::int64_t kMaxDelayNs = 1'000'000;

/// Reads the EEPROM content that an earlier simulation has stored.
void read_eeprom(TomlReader& reader, const std::filesystem::path& directory, SlaveConfig& slave) {
  if (!reader.has("sii_file")) return;
  slave.sii_file = directory / reader.text("sii_file");
  auto content = slaves::SiiFile(slave.sii_file).load();
  if (!content) reader.fail("sii_file", describe(content.error()));
  slave.sii_content = std::move(*content);
}

/// Reads the quirks of the simulated device. A stored EEPROM replaces the content that an EEPROM persona would change.
std::vector<slaves::Persona> read_personas(TomlReader& reader) {
  if (!reader.has("persona")) return {};
  const auto words = reader.is_text("persona") ? std::vector{reader.text("persona")} : reader.texts_or("persona", {});
  std::vector<slaves::Persona> personas;
  for (const auto& word : words) {
    const auto persona = parse_persona(word);
    if (!persona) reader.fail("persona", persona.error().reason);
    const auto name = slaves::persona_row(persona->kind).name;
    if (slaves::has_persona(personas, persona->kind))
      reader.fail("persona", fmt::format("\"{}\" is there twice", name));
    if (slaves::changes_eeprom(persona->kind) && reader.has("sii_file")) {
      reader.fail("persona", fmt::format("\"{}\" changes the EEPROM, whose content comes from sii_file", name));
    }
    personas.push_back(*persona);
  }
  return personas;
}

/// Finds the head of the hot-connect group of a slave. Members of a group follow each other in the file as on the line.
ecat_master::HotConnectPlace find_hot_connect_place(const TomlReader& reader, const std::string& head,
                                                    const std::vector<SlaveConfig>& others) {
  const auto found = std::find_if(others.begin(), others.end(), [&](const auto& other) { return other.name == head; });
  if (found == others.end()) {
    reader.fail("hot_connect",
                fmt::format("is \"{}\": true, false, or the name of a [[slave]] above is expected", head));
  }
  if (!found->plan.hot_connect || found->plan.behind) {
    reader.fail("hot_connect",
                fmt::format("is \"{0}\", which is not the head of a group: hot_connect = true and alias or "
                            "device_id of \"{0}\" are expected",
                            head));
  }
  const ecat_master::HotConnectPlace place{static_cast<std::size_t>(found - others.begin()),
                                           static_cast<std::size_t>(others.end() - found)};
  for (auto between = found + 1; between != others.end(); ++between) {
    if (!between->plan.behind || between->plan.behind->head != place.head) {
      reader.fail("hot_connect", fmt::format("is \"{}\", but \"{}\" is between them and not in that group: the "
                                             "slaves of a group must be adjacent",
                                             head, between->name));
    }
  }
  return place;
}

}  // namespace

std::string read_slave_name(TomlReader& reader, const std::vector<SlaveConfig>& others) {
  auto name = reader.text("name");
  if (name.empty() || name.size() > kMaxNameLength) reader.fail("name", kNameLengthText);
  if (std::any_of(others.begin(), others.end(), [&](const SlaveConfig& other) { return other.name == name; })) {
    reader.fail("name", fmt::format("\"{}\" is there twice", name));
  }
  return name;
}

SlaveConfig read_slave(TomlReader reader, const LineConfig& config, DeviceFiles& files) {
  const auto& others = config.slaves;
  SlaveConfig slave;
  slave.name = read_slave_name(reader, others);
  read_slave_device(reader, config, files, slave);
  auto identity = [&reader](std::string_view key) -> std::optional<std::uint32_t> {
    if (!reader.has(key)) return std::nullopt;
    return static_cast<std::uint32_t>(reader.integer(key, 1, 0xFFFFFFFF));
  };
  slave.vendor_id = identity("vendor_id");
  slave.product_code = identity("product_code");
  slave.plan = read_slave_plan(reader, slave.esi.get());
  if (!slave.plan.hot_head.empty()) slave.plan.behind = find_hot_connect_place(reader, slave.plan.hot_head, others);
  if (slave.esi && slave.plan.pdos) {
    ecat_master::complete_pdos(*slave.esi, *slave.plan.pdos);
    if (const auto fit = ecat_master::check_pdos(*slave.esi, *slave.plan.pdos); !fit)
      reader.fail("pdo", describe(fit.error()));
  }
  slave.names = read_entry_names(reader.table("names"));
  slave.dc = read_slave_clock(reader.table("dc"));
  slave.ip = read_slave_ip(reader, others);
  slave.personas = read_personas(reader);
  read_eeprom(reader, files.directory(), slave);
  slave.delays.processing =
      nanoseconds{reader.integer_or("processing_ns", slave.delays.processing.count(), 0, kMaxDelayNs)};
  slave.delays.forwarding =
      nanoseconds{reader.integer_or("forwarding_ns", slave.delays.forwarding.count(), 0, kMaxDelayNs)};
  reader.finish();
  return slave;
}

}  // namespace driveline::runtime
