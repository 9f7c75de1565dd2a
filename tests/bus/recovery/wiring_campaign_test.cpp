// One or two faults at a time, on lines of every wiring, layout and division into groups. The reports are compared word
// by word with the faults: each fault allows certain sentences about certain slaves, requires some of them, and leaves
// all other slaves in OP without losing a cycle.
//
// DRIVELINE_CAMPAIGN_RUNS sets the number of runs (default 21), DRIVELINE_CAMPAIGN_SEED the first seed.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <iostream>
#include <random>

#include "campaign_lines.hpp"
#include "drive_line.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/port/redundant_port.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::FaultPlace;
using ecat_master::LineEvent;
using ecat_master::LineSupervisor;
using slaves::Fault;
using slaves::FaultKind;
using slaves::PortId;
using wire::AlState;

std::string gone(std::size_t slave) {
  return fmt::format("slave {}: no longer answers", slave);
}
/// Stopped by the watchdog of its outputs (ETG.1000.6 Table 11).
std::string starved(std::size_t slave) {
  return fmt::format("slave {}: left OP, is in SAFEOP with an error, AL status code 0x001B (sync manager watchdog)",
                     slave);
}
std::string back(std::size_t slave) {
  return fmt::format("slave {}: back in OP", slave);
}

std::string ring_broken(const Reached& reach, std::size_t slaves) {
  const auto first = reach.primary;
  const auto last = slaves - reach.secondary;
  auto text = fmt::format("the ring is broken between {} and {}",
                          first == 0 ? "the primary interface" : fmt::format("slave {}", first - 1),
                          reach.secondary == 0 ? "the secondary interface" : fmt::format("slave {}", last));
  if (last - first == 1) text += fmt::format(", slave {} is cut off", first);
  if (last - first > 1) text += fmt::format(", slaves {} to {} are cut off", first, last - 1);
  return text + "; process data continue over both interfaces";
}

class WiredRun {
 public:
  explicit WiredRun(unsigned seed)
      : random_(seed),
        line_(campaign_lines()[seed % campaign_lines().size()]),
        drives_(line_.wiring.slave_count(), {}, {}, line_.wiring) {
    using ecat_master::ExchangeGroupSettings;
    const std::vector<ExchangeGroupSettings> divided[] = {
        {}, {{1, 0}, {1, 0}}, {{1, 0}, {2, 1}}, {{2, 0}, {4, 1}, {1, 0}}};
    options_.layout.layout = static_cast<ecat_master::ImageLayout>(pick(0, 2));
    options_.layout.groups = divided[pick(0, std::size(divided) - 1)];
    options_.groups = std::max<std::size_t>(1, options_.layout.groups.size());
    options_.every_third_without_lrw = pick(0, 1) == 1;
    options_.acyclic_bytes = pick(0, 1) == 1 ? 200 : port::kMaxFrameBytes;
    options_.hot_connect = line_.hot_connect;
    options_.task = &watch_;
    for (const auto slave : line_.hot_connect) set_alias(slave, 0x0200 + static_cast<unsigned>(slave));
    if (line_.ring) {
      ring_ = std::make_unique<port::RedundantPort>(drives_.line(), drives_.line().secondary(), drives_.clock);
      operation_ = std::make_unique<LineOperation>(drives_, *ring_, options_);
    } else {
      operation_ = std::make_unique<LineOperation>(drives_, options_);
    }
  }

  /// Executes the run; returns the finding, empty: none.
  std::string execute() {
    if (const auto error = sentence(operation_->to_op()); !error.empty()) return name() + "start: " + error;
    operation_->run(milliseconds{20});
    LineSupervisor::Settings settings;
    settings.state_timeout = milliseconds{500};
    supervisor_ = std::make_unique<LineSupervisor>(operation_->master(), ring_.get(), settings);
    using Scenario = void (WiredRun::*)();
    constexpr Scenario kScenarios[] = {
        &WiredRun::cut_and_mend,    &WiredRun::cut_and_mend,    &WiredRun::later_one_first,
        &WiredRun::later_one_first, &WiredRun::starve,          &WiredRun::damage_frames,
        &WiredRun::disturb,         &WiredRun::refuse_to_go_up, &WiredRun::be_silent};
    for (int i = 0; i < 4 && wrong_.empty(); ++i) {
      begin();
      (this->*kScenarios[pick(0, std::size(kScenarios) - 1)])();
      end();
    }
    if (!wrong_.empty()) return name() + done_ + ": " + wrong_ + "\n" + told();
    const auto down = sentence(operation_->master().shut_down());
    return down.empty() ? "" : name() + done_ + "on the way down: " + down;
  }
  [[nodiscard]] std::uint64_t recoveries() const noexcept { return supervisor_->recoveries(); }

 private:
  std::size_t pick(std::size_t from, std::size_t to) {
    return std::uniform_int_distribution<std::size_t>(from, to)(random_);
  }
  milliseconds pick_time(int from, int to) {
    return milliseconds{static_cast<int>(pick(static_cast<std::size_t>(from), static_cast<std::size_t>(to)))};
  }
  [[nodiscard]] std::string name() const { return std::string(line_.name) + ": "; }
  void note(const std::string& problem) {
    if (wrong_.empty()) wrong_ = problem;
  }

  void set_alias(std::size_t slave, unsigned alias) {
    drives_.line().set_power(slave, false);
    auto& sii = drives_.slave(slave).esc().sii();
    sii.corrupt(8, static_cast<std::byte>(alias & 0xFF));
    sii.corrupt(9, static_cast<std::byte>(alias >> 8));
    sii.corrupt(14, static_cast<std::byte>(esi::sii_checksum(sii.image().first<esi::SiiConfigArea::kSize>())));
    drives_.line().set_power(slave, true);
  }

  void live(nanoseconds duration) {
    const auto until = drives_.clock.now() + duration;
    while (drives_.clock.now() < until) {
      operation_->run(milliseconds{2});
      supervisor_->poll();
      check_addresses();
    }
    operation_->axis_samples.clear();
    operation_->line_samples.clear();
  }
  /// Checks that no slave ever has the station address of another.
  void check_addresses() {
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      const auto station = drives_.slave(i).esc().memory().get(wire::reg::kStationAddress);
      for (const auto& other : operation_->master().slaves()) {
        if (other.info.ref.position != i && other.info.ref.station == station)
          note(fmt::format("slave {} has the address of slave {}", i, other.info.ref.position));
      }
    }
  }

  void begin() {
    first_event_ = supervisor_->history().size();
    allowed_.clear();
    demanded_.clear();
    affected_.clear();
    cuts_ = {};
    watch_.invalid.fill(0);
    frames_lost_ = false;
  }
  void allow(const std::string& text) { allowed_.insert(text); }
  void demand(const std::string& text) {
    allow(text);
    demanded_.insert(text);
  }

  /// All slaves must have recovered, and the reports must be the expected ones.
  void end() {
    const auto until = drives_.clock.now() + std::chrono::seconds{10};
    do {
      live(milliseconds{10});
    } while (!fine() && drives_.clock.now() < until);
    if (!fine()) note("somebody is not back");
    std::set<std::string> out;
    auto missing = demanded_;
    for (auto i = first_event_; i < supervisor_->history().size(); ++i) {
      const auto& event = supervisor_->history()[i];
      const auto text = what_happened(event);
      missing.erase(text);
      const auto who = fmt::format("slave {}", event.slave);
      using Kind = LineEvent::Kind;
      if (event.kind == Kind::kRecovered) {
        if (text != back(event.slave) || out.erase(who) == 0) note("comes back without having left: " + text);
        continue;
      }
      if (!allowed_.contains(text)) note("wrong sentence: " + text);
      if ((event.kind == Kind::kGone || event.kind == Kind::kLeftOp) && !out.insert(who).second)
        note("leaves twice: " + text);
    }
    if (!out.empty()) note("never told to be back: " + *out.begin());
    if (!missing.empty()) note("never told: " + *missing.begin());
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      if (frames_lost_ || affected_.contains(i) || watch_.invalid[i] == 0) continue;
      note(fmt::format("slave {} lost {} cycles", i, watch_.invalid[i]));
    }
  }
  bool fine() {
    if (!supervisor_->all_operational() || !drives_.all_in(AlState::kOp)) return false;
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      if (!operation_->master().core()->slave_report(i).operational) return false;
    }
    return ring_ == nullptr || ring_->status().state == port::RingStatus::State::kClosed;
  }

  /// Slaves that cannot be reached are missing, and slaves without outputs for some time have been stopped by their
  /// watchdogs.
  void cuts_changed() {
    const auto reach = reached(line_.wiring, cuts_);
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      if (reach.slaves.contains(i)) continue;
      affected_.insert(i);
      allow(gone(i));
      // A slave that returns before it is missed may be seen in SAFEOP first; without supply it has lost its address.
      if (!cuts_.off.contains(i)) allow(starved(i));
    }
    if (!line_.ring) return;
    if (!reach.closed) allow(ring_broken(reach, drives_.size()));
    allow("the ring is closed again");
  }
  void expect_cut_now() {
    const auto reach = reached(line_.wiring, cuts_);
    // The line is silent then, and slaves cannot be distinguished.
    if (reach.slaves.empty()) return;
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      if (reach.slaves.contains(i)) continue;
      demand(gone(i));
      if (supervisor_->operational(i)) note(fmt::format("slave {} is out of reach, and nobody noticed", i));
    }
    if (line_.ring && !reach.closed) demand(ring_broken(reach, drives_.size()));
  }

  void cut_and_mend() {
    struct Cut {
      bool power;
      std::size_t slave;
      PortId cable;
    };
    std::vector<Cut> made;
    const auto wires = cables(line_.wiring);
    const auto count = pick(1, 2);
    for (std::size_t i = 0; i < count; ++i) {
      const Cut cut{pick(0, 2) > 0, pick(0, drives_.size() - 1), wires[pick(0, wires.size() - 1)]};
      done_ += cut.power ? fmt::format("power {} off, ", cut.slave)
                         : fmt::format("cable {}:{} broken, ", cut.cable.slave, cut.cable.port);
      if (cut.power) {
        drives_.line().set_power(cut.slave, false);
        cuts_.off.insert(cut.slave);
      } else {
        drives_.line().break_cable(cut.cable);
        cuts_.broken.push_back(cut.cable);
      }
      made.push_back(cut);
      cuts_changed();
      if (pick(0, 1) == 1) live(pick_time(1, 150));
    }
    live(milliseconds{60});
    expect_cut_now();
    std::shuffle(made.begin(), made.end(), random_);
    for (const auto& cut : made) {
      if (cut.power) {
        drives_.line().set_power(cut.slave, true);
        cuts_.off.erase(cut.slave);
      } else {
        drives_.line().break_cable(cut.cable, false);
        std::erase(cuts_.broken, cut.cable);
      }
      cuts_changed();
      live(pick_time(1, 400));
    }
  }

  void switch_power(std::size_t slave, bool on) {
    drives_.line().set_power(slave, on);
    if (on) cuts_.off.erase(slave);
    if (!on) cuts_.off.insert(slave);
    cuts_changed();
  }
  /// Switches off two slaves that do not depend on each other; the one later on the line returns first.
  void later_one_first() {
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t second = 0; second < drives_.size(); ++second) {
      for (std::size_t first = 0; first < second; ++first) {
        const bool apart = reached(line_.wiring, {{first}, {}}).slaves.contains(second);
        if (apart) pairs.emplace_back(first, second);
      }
    }
    if (pairs.empty()) return cut_and_mend();
    const auto [first, second] = pairs[pick(0, pairs.size() - 1)];
    done_ += fmt::format("power {} and {} off, {} back first, ", first, second, second);
    for (const auto slave : {first, second}) switch_power(slave, false);
    live(milliseconds{60});
    expect_cut_now();
    switch_power(second, true);
    live(pick_time(20, 400));
    switch_power(first, true);
  }

  /// The slave ignores the process data.
  void starve() {
    const auto slave = pick(0, drives_.size() - 1);
    done_ += fmt::format("short-wkc {}, ", slave);
    frames_lost_ = true;  // an unexplained working counter makes its datagram invalid
    drives_.line().inject({.kind = FaultKind::kShortWorkingCounter,
                           .slave = static_cast<std::uint16_t>(slave),
                           .duration = milliseconds{200}});
    demand(starved(slave));
    live(milliseconds{220});
  }

  /// Damages a few frames on one cable: the counters identify this cable only, and no slave is blamed.
  void damage_frames() {
    const auto wires = cables(line_.wiring);
    auto at = wires[pick(0, wires.size() - 1)];
    // In a closed ring, frames of the primary interface pass in one direction only.
    if (line_.ring || pick(0, 1) == 1) at = line_.wiring.at(at).slave;
    done_ += fmt::format("damage {}:{}, ", at.slave, at.port);
    frames_lost_ = true;
    if (const auto error = sentence(ecat_master::clear_error_counters(operation_->master().bus())); !error.empty())
      return note(error);
    drives_.line().inject({.kind = FaultKind::kDamage,
                           .slave = static_cast<std::uint16_t>(at.slave),
                           .port = static_cast<std::uint8_t>(at.port),
                           .count = static_cast<std::uint32_t>(pick(1, 6))});
    live(milliseconds{20});
    const auto found = diagnose(operation_->master(), supervisor_.get(), ring_.get());
    if (!found) return note(sentence(found));
    std::size_t named = 0;
    for (const auto& place : found->places) {
      if (place.kind != FaultPlace::Kind::kDamagedFrames) continue;
      const bool right = place.slave == at.slave && place.port == at.port &&
                         place.other == std::optional(static_cast<std::uint16_t>(line_.wiring.at(at).slave.slave));
      named += right ? 1 : 0;
      if (!right) note("wrong cable: " + describe(place));
    }
    if (named != 1) note("the cable is not named");
  }

  /// Late and duplicated frames must not be blamed on a slave.
  void disturb() {
    done_ += "late and doubled frames, ";
    frames_lost_ = true;
    drives_.line().inject({.kind = FaultKind::kDelay,
                           .count = static_cast<std::uint32_t>(pick(1, 5)),
                           .time = microseconds{static_cast<int>(pick(100, 400))}});
    live(milliseconds{20});
    drives_.line().inject({.kind = FaultKind::kDuplicate, .count = static_cast<std::uint32_t>(pick(1, 20))});
    live(milliseconds{20});
  }

  void refuse_to_go_up() {
    const auto slave = pick(0, drives_.size() - 1);
    done_ += fmt::format("slave {} refuses OP, ", slave);
    affected_.insert(slave);
    const Fault refusal{.kind = FaultKind::kRefuseTransition,
                        .slave = static_cast<std::uint16_t>(slave),
                        .state = AlState::kOp,
                        .code = wire::AlStatusCode::kFatalSyncError};
    drives_.line().inject(refusal);
    const auto& ref = operation_->master().slaves()[slave].info.ref;
    const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
    static_cast<void>(operation_->master().bus().write(ref, wire::reg::kAlControl, value).has_value());
    demand(fmt::format("slave {}: left OP, is in SAFEOP, AL status code 0x0000 (no error)", slave));
    demand(fmt::format(
        "slave {0}: not brought back to OP: slave {0}: requested OP, is in SAFEOP + error, AL status code 0x002C "
        "(fatal synchronization error)",
        slave));
    live(milliseconds{150});
    drives_.line().heal(refusal);
  }

  /// After power-on the slave accepts mailbox messages and does not answer.
  void be_silent() {
    const auto slave = pick(0, drives_.size() - 1);
    done_ += fmt::format("slave {} is silent after power-on, ", slave);
    const Fault silence{.kind = FaultKind::kMailboxSilent, .slave = static_cast<std::uint16_t>(slave)};
    drives_.line().set_power(slave, false);
    cuts_.off.insert(slave);
    cuts_changed();
    live(milliseconds{60});
    expect_cut_now();
    drives_.line().inject(silence);
    drives_.line().set_power(slave, true);
    cuts_.off.erase(slave);
    // The first start-up SDO of the plan.
    const auto& first = operation_->master().slaves()[slave].plan.startup_sdos.front();
    demand(
        fmt::format("slave {0}: not brought back to OP: slave {0}: no mailbox reply for object {1:04X}h:{2:02X} "
                    "within 2000 ms",
                    slave, first.index, first.subindex));
    live(std::chrono::seconds{3});
    drives_.line().heal(silence);
  }

  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor_->history()) all += describe(event) + "\n";
    return all;
  }

  /// Counts the cycles in which the data of a slave were not valid.
  struct Watch final : motion::CycleTask {
    void update(const motion::TaskCycle& now) noexcept override {
      const auto valid = now.valid;
      for (std::size_t i = 0; i < valid.size(); ++i) invalid[i] += valid[i] ? 0 : 1;
    }
    std::array<std::uint64_t, 16> invalid{};
  };

  std::mt19937 random_;
  CampaignLine line_;
  DriveLine drives_;
  RunOptions options_;
  Watch watch_;
  std::unique_ptr<port::RedundantPort> ring_;
  std::unique_ptr<LineOperation> operation_;
  std::unique_ptr<LineSupervisor> supervisor_;
  std::size_t first_event_ = 0;
  std::set<std::string> allowed_;
  std::set<std::string> demanded_;
  std::set<std::size_t> affected_;
  Cuts cuts_;
  bool frames_lost_ = false;
  std::string wrong_;
  std::string done_;
};

TEST(WiringCampaign, WhatIsToldIsWhatWasDone) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(21U));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  std::uint64_t recoveries = 0;
  unsigned failures = 0;
  for (unsigned i = 0; i < runs; ++i) {
    WiredRun run(first + i);
    const auto wrong = run.execute();
    EXPECT_EQ(wrong, "") << "seed " << first + i;
    if (!wrong.empty() && ++failures == 10) FAIL() << "enough";
    if (wrong.empty()) recoveries += run.recoveries();
    if (i % 100 == 99) std::cout << i + 1 << " runs, " << recoveries << " recoveries" << std::endl;
  }
  EXPECT_GT(recoveries, runs);
}

}  // namespace
}  // namespace driveline::bus_test
