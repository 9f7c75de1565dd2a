#include "config/wiring_config.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "driveline/slaves/line/frame_path.hpp"

namespace driveline::runtime {

using slaves::MasterPort;
using slaves::PortId;
using slaves::Wiring;
using std::chrono::nanoseconds;
using SlaveNames = std::span<const std::string>;

namespace {

/// Signals on copper travel about 20 cm per nanosecond (ISO/IEC 11801: at most 5.38 ns/m for 100BASE-TX cable).
constexpr double kDelayPerMetreNs = 5.0;
constexpr double kMaxCableM = 100000.0;  // with media converters
/// Ports at which the branches of a junction start, in the order in which the frame passes them (ESC data sheet I).
constexpr std::array<unsigned, 3> kBranchPorts = {3, 1, 2};

enum class Preset { kLine, kRing, kStar, kBranch, kCustom };

nanoseconds cable_delay(double length_m) {
  return nanoseconds{std::llround(length_m * kDelayPerMetreNs)};
}

/// One end of a cable, as named in the file.
struct CableEnd {
  std::optional<PortId> slave;
  MasterPort master = MasterPort::kPrimary;
};

std::optional<std::size_t> position_of(std::string_view name, SlaveNames names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

CableEnd read_end(TomlReader& reader, std::string_view key, SlaveNames names) {
  const auto text = reader.text(key);
  if (text == "master") return {std::nullopt, MasterPort::kPrimary};
  if (text == "master2") return {std::nullopt, MasterPort::kSecondary};
  const auto colon = text.rfind(':');
  const auto port = colon == std::string::npos ? std::string{} : text.substr(colon + 1);
  const auto slave = position_of(std::string_view(text).substr(0, colon), names);
  if (!slave || port.size() != 1 || port[0] < '0' || port[0] > '3') {
    reader.fail(key,
                fmt::format("is \"{}\", the name of a [[slave]] and its port (\"{}:1\"), \"master\" or \"master2\" "
                            "is expected",
                            text, names.front()));
  }
  return {PortId{*slave, static_cast<unsigned>(port[0] - '0')}, {}};
}

bool connects(const Wiring& wiring, const CableEnd& a, const CableEnd& b) {
  if (a.slave && b.slave) {
    const auto& end = wiring.at(*a.slave);
    return end.kind == Wiring::End::Kind::kSlave && end.slave == *b.slave;
  }
  const auto& slave = a.slave ? a.slave : b.slave;
  return slave && wiring.master(a.slave ? b.master : a.master) == slave;
}

/// Connects a line of slaves to `before`; without `before`, to the master's interface.
void connect_chain(Wiring& wiring, std::optional<PortId> before, std::size_t first, std::size_t count,
                   nanoseconds delay) {
  for (std::size_t i = first; i < first + count; ++i) {
    if (before) {
      wiring.connect(*before, {i, 0}, delay);
    } else {
      wiring.connect_master(MasterPort::kPrimary, {i, 0}, delay);
    }
    before = PortId{i, 1};
  }
}

/// Makes a star: the first slave is the junction, and the others form arms of the same length at its ports.
Wiring make_star(TomlReader& reader, std::size_t count, nanoseconds delay) {
  const auto arms = static_cast<std::size_t>(reader.integer_or("arms", 3, 1, kBranchPorts.size()));
  Wiring wiring(count);
  connect_chain(wiring, std::nullopt, 0, 1, delay);
  std::size_t first = 1;
  for (std::size_t arm = 0; arm < arms; ++arm) {
    const std::size_t left = count - first;
    const std::size_t length = (left + (arms - arm) - 1) / (arms - arm);
    connect_chain(wiring, PortId{0, kBranchPorts[arm]}, first, length, delay);
    first += length;
  }
  return wiring;
}

/// Makes a line with a branch at port 3 of a slave: the branch holds the next slaves in the file; the rest of the
/// line follows them.
Wiring make_branch(TomlReader& reader, SlaveNames names, nanoseconds delay) {
  const auto name = reader.text("junction");
  const auto junction = position_of(name, names);
  if (!junction) reader.fail("junction", fmt::format("there is no [[slave]] named \"{}\"", name));
  const std::size_t behind = names.size() - *junction - 1;
  const auto length = static_cast<std::size_t>(
      reader.integer("branch_slaves", 1, static_cast<std::int64_t>(std::max<std::size_t>(behind, 1))));
  if (behind == 0) reader.fail("junction", fmt::format("\"{}\" is the last [[slave]], nothing can branch off", name));
  Wiring wiring(names.size());
  connect_chain(wiring, std::nullopt, 0, *junction + 1, delay);
  connect_chain(wiring, PortId{*junction, 3}, *junction + 1, length, delay);
  connect_chain(wiring, PortId{*junction, 1}, *junction + 1 + length, behind - length, delay);
  return wiring;
}

void read_cable(TomlReader reader, SlaveNames names, Preset preset, double default_m, Wiring& wiring) {
  const auto from = read_end(reader, "from", names);
  const auto to = read_end(reader, "to", names);
  const auto delay = cable_delay(reader.number_or("length_m", default_m, 0.0, kMaxCableM));
  reader.finish();
  if (preset != Preset::kCustom) {
    if (!connects(wiring, from, to)) {
      reader.fail("from", "the preset has no such cable; preset = \"custom\" takes all cables from the file");
    }
    wiring.set_delay(from.slave ? *from.slave : *to.slave, delay);
    return;
  }
  bool done = false;
  if (from.slave && to.slave) {
    done = wiring.connect(*from.slave, *to.slave, delay);
  } else if (from.slave || to.slave) {
    done = wiring.connect_master(from.slave ? to.master : from.master, from.slave ? *from.slave : *to.slave, delay);
  }
  if (!done) reader.fail("from", "cannot be connected: one of the two ends is taken already, or both are the same");
}

/// Checks that the frame passes the slaves in the order of the file, because all other code relies on positions on the
/// line.
void check_order(const TomlReader& reader, const Wiring& wiring, SlaveNames names) {
  if (!wiring.master(MasterPort::kPrimary)) {
    reader.fail("", "no cable leads to \"master\": connect port 0 of the first slave to it");
  }
  std::vector<slaves::SlavePorts> ports(names.size());
  for (std::size_t i = 0; i < ports.size(); ++i) {
    for (unsigned port = 0; port < slaves::kPortCount; ++port) {
      ports[i].closed[port] = wiring.at({i, port}).kind == Wiring::End::Kind::kNothing;
    }
  }
  slaves::FramePath path;
  path.trace(wiring, ports, MasterPort::kPrimary);
  const auto steps = path.steps();
  for (std::size_t i = 0; i < std::min(steps.size(), names.size()); ++i) {
    if (steps[i].slave == i) continue;
    reader.fail("", fmt::format("the frame meets \"{}\" where the file has \"{}\": list the [[slave]] tables in the "
                                "order of the frame, which leaves a slave at port 3 first, then 1, then 2",
                                names[steps[i].slave], names[i]));
  }
  if (steps.size() != names.size()) {
    reader.fail("", fmt::format("the frame never reaches \"{}\": connect its port 0 to a slave upstream of it",
                                names[std::min(steps.size(), names.size() - 1)]));
  }
  if (!path.exit()) reader.fail("", "the frame never comes back to the master");
}

}  // namespace

Wiring read_wiring(TomlReader reader, SlaveNames names) {
  const auto preset = static_cast<Preset>(reader.choice_or("preset", 0, {"line", "ring", "star", "branch", "custom"}));
  const double cable_m = reader.number_or("cable_m", 1.0, 0.0, kMaxCableM);
  const auto delay = cable_delay(cable_m);
  Wiring wiring(names.size());
  switch (preset) {
    case Preset::kLine:
      wiring = Wiring::line(names.size(), delay);
      break;
    case Preset::kRing:
      wiring = Wiring::ring(names.size(), delay);
      break;
    case Preset::kStar:
      wiring = make_star(reader, names.size(), delay);
      break;
    case Preset::kBranch:
      wiring = make_branch(reader, names, delay);
      break;
    case Preset::kCustom:
      break;
  }
  for (auto& cable : reader.tables("cable")) read_cable(std::move(cable), names, preset, cable_m, wiring);
  reader.finish();
  check_order(reader, wiring, names);
  return wiring;
}

}  // namespace driveline::runtime
