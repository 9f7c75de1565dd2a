// Detects registers that have changed since the master wrote them, by reading them back slave by slave.
#include <algorithm>

#include "driveline/ecat_master/recovery/line_supervisor.hpp"

namespace driveline::ecat_master {
void LineSupervisor::watch_registers() {
  if (!settings_.guard_registers) return;
  if (const auto slave = next_guarded()) guard(*slave);
}

/// The next slave with invalid process data, else the next slave in turn.
std::optional<std::size_t> LineSupervisor::next_guarded() {
  const auto count = slaves_.size();
  const auto take = [&](std::size_t slave) {
    if (slave == 0) round_began_ = master_.bus().exchange().now();
    next_guarded_ = (slave + 1) % count;
    return slave;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const auto slave = (next_guarded_ + i) % count;
    if (slaves_[slave].suspicious && !slaves_[slave].trouble) return take(slave);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto slave = (next_guarded_ + i) % count;
    if (!slaves_[slave].trouble) return take(slave);
  }
  return std::nullopt;
}

void LineSupervisor::guard(std::size_t slave) {
  auto& one = slaves_[slave];
  one.suspicious = false;
  ++guard_.looks;
  const auto changes = master_.changed_registers(slave);
  if (next_guarded_ == 0) {
    ++guard_.rounds;
    guard_.last_round = master_.bus().exchange().now() - round_began_;
  }
  if (!changes) {
    // No slave, or several slaves, answer at its address.
    if (changes.error().is<facts::WorkingCounter>()) restore_addresses();
    return;
  }
  if (changes->empty()) {
    one.restore_noted = false;
    return;
  }
  // Another slave with different registers may answer at its address.
  if (restore_addresses()) return;
  note_changes(slave, *changes);
}

void LineSupervisor::note_changes(std::size_t slave, std::span<const RegisterChange> changes) {
  auto& one = slaves_[slave];
  const auto worst = std::find_if(changes.begin(), changes.end(), [](const RegisterChange& change) {
    return change.guarded.repair == RegisterRepair::kReconfigure;
  });
  LineEvent event{.kind = LineEvent::Kind::kRegistersRestored, .slave = static_cast<std::uint16_t>(slave)};
  event.count = static_cast<std::uint16_t>(changes.size());
  event.time = master_.bus().exchange().now();
  if (worst == changes.end()) {
    // Report a failure once; the next round tries again.
    if (!rewrite(master_.bus(), master_.slaves()[slave].info.ref, changes) || one.restore_noted) return;
    one.restore_noted = true;
    event.change = changes.front();
  } else {
    one.trouble = true;
    one.noted_failure.reset();
    master_.core()->set_recovering(slave, true);
    event.kind = LineEvent::Kind::kRegistersChanged;
    event.change = *worst;
  }
  guard_.changes += changes.size();
  note(event);
}

/// Restores station addresses; returns true if any had to be restored. Reports only slaves that stayed in OP, because
/// slaves that were away have lost their addresses anyway.
bool LineSupervisor::restore_addresses() {
  // A failure is not reported: the next call tries the missing slaves again.
  const auto moved = master_.readdress_newcomers();
  if (!moved) return false;
  for (const auto& one : *moved) {
    if (slaves_[one.slave].trouble) continue;
    LineEvent event{.kind = LineEvent::Kind::kRegistersRestored, .slave = one.slave, .count = 1};
    event.time = master_.bus().exchange().now();
    event.change = {{wire::reg::kStationAddress.address, sizeof(wire::reg::kStationAddress.reset),
                     RegisterRepair::kRewrite, master_.slaves()[one.slave].info.ref.station},
                    one.found};
    slaves_[one.slave].suspicious = true;
    ++guard_.changes;
    note(event);
  }
  return !moved->empty();
}

}  // namespace driveline::ecat_master
