// The faults of the emulated line, several at a time, repeated with different seeds: the reports must fit the faults
// (deeds.hpp), and all slaves must have recovered at the end.
// DRIVELINE_CAMPAIGN_RUNS sets the number of runs (default 40), DRIVELINE_CAMPAIGN_SEED the first seed.
#include <gmock/gmock.h>
#include <malloc.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <set>

#include "deeds.hpp"
#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineEvent;
using ecat_master::LineSupervisor;
using motion::MotionPhase;
using slaves::Fault;
using slaves::FaultDirection;
using slaves::FaultKind;

/// A run of the campaign.
class CampaignRun {
 public:
  explicit CampaignRun(unsigned seed) : random_(seed), drives_(pick(3, 5)) {
    options_.repeat = true;
    options_.amplitude_rad = 0.1;
    options_.layout.layout = static_cast<ecat_master::ImageLayout>(pick(0, 2));
    options_.groups = pick(1, 2);
    options_.every_third_without_lrw = pick(0, 1) == 1;
    options_.acyclic_bytes = pick(0, 1) == 1 ? 300 : port::kMaxFrameBytes;
    operation_ = std::make_unique<LineOperation>(drives_, options_);
  }

  /// Executes the run; returns the finding, empty: none.
  std::string execute() {
    if (const auto error = sentence(operation_->to_motion()); !error.empty()) return "start: " + error;
    operation_->run(milliseconds{20});
    before_ = configuration();
    LineSupervisor::Settings settings;
    settings.state_timeout = milliseconds{500};
    supervisor_ = std::make_unique<LineSupervisor>(operation_->master(), nullptr, settings);
    const auto faults = pick(2, 5);
    for (std::size_t i = 0; i < faults; ++i) {
      inject();
      live(milliseconds{static_cast<int>(pick(5, 150))});
    }
    if (!settle()) return "stuck after: " + faults_ + told();
    const auto first = supervisor_->events();
    const auto slave = take_away_one();
    if (!settle()) return "stuck after one that was hindered: " + faults_ + told();
    if (!failure_told(slave, first)) return "never told why it was not back at once, after: " + faults_ + told();
    // Time for the last round of register reading, and for its findings.
    live(milliseconds{50});
    if (!settle()) return "stuck after a look at the registers: " + faults_ + told();
    if (const auto lost = changed_register(); !lost.empty()) return lost + " after: " + faults_ + told();
    if (const auto wrong = deeds_.judge(supervisor_->history(), drives_.size()); !wrong.empty())
      return wrong + " after: " + faults_ + told();
    if (const auto wrong = wrong_sentence(); !wrong.empty()) return wrong + " after: " + faults_ + told();
    return drive_on();
  }
  [[nodiscard]] const std::set<FaultKind>& kinds() const noexcept { return kinds_; }
  [[nodiscard]] std::size_t demanded() const noexcept { return deeds_.demanded(); }
  /// Kinds of the reported sentences.
  [[nodiscard]] std::set<LineEvent::Kind> told_kinds() const {
    std::set<LineEvent::Kind> kinds;
    for (const auto& event : supervisor_->history()) kinds.insert(event.kind);
    return kinds;
  }
  [[nodiscard]] std::uint64_t recoveries() const noexcept { return supervisor_->recoveries(); }
  [[nodiscard]] std::uint64_t registers() const noexcept { return supervisor_->guard().changes; }

 private:
  std::size_t pick(std::size_t from, std::size_t to) {
    return std::uniform_int_distribution<std::size_t>(from, to)(random_);
  }

  void live(nanoseconds duration) {
    const auto end = drives_.clock.now() + duration;
    while (drives_.clock.now() < end) {
      operation_->run(milliseconds{4});
      supervisor_->poll();
    }
    operation_->axis_samples.clear();
    operation_->line_samples.clear();
  }

  void inject() {
    Fault fault;
    fault.kind = static_cast<FaultKind>(pick(0, slaves::kFaultKindCount - 1));
    fault.slave = static_cast<std::uint16_t>(pick(0, drives_.size() - 1));
    fault.duration = milliseconds{static_cast<int>(pick(5, 200))};
    fault.seed = static_cast<std::uint32_t>(pick(1, 1'000'000));
    fault.time = microseconds{static_cast<int>(pick(50, 5000))};
    fault.direction = pick(0, 1) == 0 ? FaultDirection::kOut : FaultDirection::kBack;
    switch (fault.kind) {
      case FaultKind::kDrop:
      case FaultKind::kDamage:
        // Long enough for watchdogs, or a few frames.
        fault.chance = pick(0, 2) == 0 ? 1.0 : 0.2;
        break;
      case FaultKind::kDelay:
        fault.count = static_cast<std::uint32_t>(pick(1, 30));
        fault.time = microseconds{static_cast<int>(pick(20, 400))};
        break;
      case FaultKind::kCorrupt:
        // Damage on the way back affects the master only; on the way out it may change anything in the slaves,
        // registers included.
        fault.count = static_cast<std::uint32_t>(pick(1, 20));
        fault.bits = static_cast<std::uint32_t>(pick(1, 4));
        break;
      case FaultKind::kCableBreak:
        // Port 0 leads towards the master.
        fault.port = 0;
        break;
      case FaultKind::kRefuseTransition:
        fault.state = pick(0, 1) == 0 ? wire::AlState::kOp : wire::AlState::kSafeOp;
        fault.code = wire::AlStatusCode::kUnspecifiedError;
        break;
      case FaultKind::kEepromChecksum:
        reload_.insert(fault.slave);
        break;
      default:
        break;
    }
    inject(fault);
  }
  void inject(const Fault& fault) {
    if (!drives_.line().inject(fault)) return;
    kinds_.insert(fault.kind);
    deeds_.add(fault, drives_.clock.now());
    faults_ += std::string(slaves::fault_kind_row(fault.kind).name) + " slave " + std::to_string(fault.slave) + ", ";
  }

  /// Cuts off a slave without any other fault, so it must be reported; then disturbs its recovery.
  std::uint16_t take_away_one() {
    constexpr FaultKind kTaken[] = {FaultKind::kPowerOff, FaultKind::kCableBreak, FaultKind::kShortWorkingCounter};
    constexpr FaultKind kHindered[] = {FaultKind::kRefuseTransition, FaultKind::kSlowTransition,
                                       FaultKind::kMailboxSilent, FaultKind::kMailboxBusy, FaultKind::kEepromBusy};
    const auto slave = static_cast<std::uint16_t>(pick(1, drives_.size() - 1));
    inject({.kind = kTaken[pick(0, std::size(kTaken) - 1)], .slave = slave, .duration = milliseconds{150}});
    live(milliseconds{300});
    settle();
    inject({.kind = FaultKind::kPowerOff, .slave = slave, .duration = milliseconds{50}});
    inject({.kind = kHindered[pick(0, std::size(kHindered) - 1)],
            .slave = slave,
            .time = std::chrono::seconds{1},
            .state = wire::AlState::kOp,
            .code = wire::AlStatusCode::kUnspecifiedError,
            .duration = std::chrono::seconds{3}});  // the mailbox time-out is up to 2 s
    live(milliseconds{300});
    return slave;
  }
  /// Whether a failed recovery of the slave was reported after the first `first` events.
  bool failure_told(std::uint16_t slave, std::uint64_t first) {
    const auto& history = supervisor_->history();
    const auto fresh = static_cast<std::ptrdiff_t>(supervisor_->events() - first);
    return std::any_of(history.end() - fresh, history.end(), [&](const LineEvent& event) {
      return event.kind == LineEvent::Kind::kRecoveryFailed && event.slave == slave;
    });
  }

  /// Waits until all faults have ended and all slaves have recovered.
  bool settle() {
    const auto end = drives_.clock.now() + std::chrono::seconds{30};
    while (!drives_.line().faults().active().empty() && drives_.clock.now() < end) live(milliseconds{20});
    for (const auto slave : reload_) {
      // An EEPROM that was found damaged is reloaded when the slave is switched on.
      const Fault off{
          .kind = FaultKind::kPowerOff, .slave = static_cast<std::uint16_t>(slave), .duration = milliseconds{10}};
      deeds_.add(off, drives_.clock.now());
      drives_.line().set_power(slave, false);
      live(milliseconds{10});
      drives_.line().set_power(slave, true);
    }
    do {
      live(milliseconds{20});
    } while (!fine() && drives_.clock.now() < end);
    return fine();
  }
  bool fine() {
    if (!supervisor_->all_operational() || !drives_.all_in(wire::AlState::kOp)) return false;
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      if (!operation_->master().core()->slave_report(i).operational) return false;
    }
    return operation_->master().core()->bad_cycles() == 0;
  }

  struct Byte {
    std::size_t slave;
    std::size_t address;
    std::byte value;
  };
  /// The registers with the configuration of all slaves, without the parts that slaves and mailboxes change.
  std::vector<Byte> configuration() {
    std::vector<Byte> all;
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      const auto take = [&](std::size_t from, std::size_t bytes, std::byte bits = std::byte{0xFF}) {
        for (auto at = from; at < from + bytes; ++at) {
          all.push_back({i, at, drives_.slave(i).esc().memory().at(at, 1)[0] & bits});
        }
      };
      for (const std::size_t address : {0x0010U, 0x0400U, 0x0410U, 0x0420U}) take(address, 2);
      for (const std::size_t address : {0x0021U, 0x0031U}) take(address, 1);
      take(0x0100, 4);
      take(0x0600, 8 * std::size_t{16});
      for (std::size_t n = 0; n < 8; ++n) {
        take(0x0800 + 8 * n, 5);
        take(0x0806 + 8 * n, 1, std::byte{0xC1});
      }
    }
    return all;
  }
  std::string changed_register() {
    const auto now = configuration();
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now[i].value == before_[i].value) continue;
      return "slave " + std::to_string(now[i].slave) + " is in OP with another byte at " +
             std::to_string(now[i].address);
    }
    return {};
  }

  std::string wrong_sentence() {
    std::set<std::uint16_t> out;
    for (const auto& event : supervisor_->history()) {
      const auto text = describe(event);
      const bool returned = event.kind == LineEvent::Kind::kRecovered;
      const bool lost = event.kind == LineEvent::Kind::kGone || event.kind == LineEvent::Kind::kLeftOp;
      if (returned && out.erase(event.slave) == 0) return "comes back without having left: " + text;
      if (lost && !out.insert(event.slave).second) return "leaves twice: " + text;
      // Register changes are also reported as the reason for leaving OP.
      if (event.kind == LineEvent::Kind::kRegistersChanged) out.insert(event.slave);
      if (event.kind == LineEvent::Kind::kRecoveryFailed && out.count(event.slave) == 0)
        return "fails at nothing: " + text;
    }
    if (!out.empty()) return "never told that slave " + std::to_string(*out.begin()) + " is back";
    const auto back = std::count_if(supervisor_->history().begin(), supervisor_->history().end(),
                                    [](const LineEvent& event) { return event.kind == LineEvent::Kind::kRecovered; });
    const bool counted = static_cast<std::uint64_t>(back) == supervisor_->recoveries();
    return counted ? "" : "counts " + std::to_string(supervisor_->recoveries()) + " recoveries";
  }

  /// Checks that the line works as before.
  std::string drive_on() {
    operation_->motion().request_stop();
    if (!operation_->run_until(MotionPhase::kIdle, std::chrono::seconds{5})) return "does not come to rest: " + faults_;
    operation_->motion().request_start();
    if (!operation_->run_until(MotionPhase::kFollowing, std::chrono::seconds{5})) {
      return "does not move again (" + std::string(to_text(operation_->motion().phase())) + "): " + faults_;
    }
    operation_->motion().request_stop();
    if (!operation_->run_until(MotionPhase::kIdle, std::chrono::seconds{5})) return "does not stop: " + faults_;
    const auto down = sentence(operation_->master().shut_down());
    return down.empty() ? std::string() : "on the way down: " + down + " after: " + faults_;
  }

  [[nodiscard]] std::string told() const {
    std::string all = "\n";
    for (const auto& event : supervisor_->history()) all += describe(event) + "\n";
    return all;
  }

  std::mt19937 random_;
  DriveLine drives_;
  RunOptions options_;
  std::unique_ptr<LineOperation> operation_;
  std::unique_ptr<LineSupervisor> supervisor_;
  std::set<std::size_t> reload_;
  std::vector<Byte> before_;
  std::set<FaultKind> kinds_;
  Deeds deeds_;
  std::string faults_;
};

/// Sums over all runs.
struct CampaignSum {
  std::uint64_t recoveries = 0;
  std::uint64_t registers = 0;
  std::size_t demanded = 0;
  std::set<FaultKind> faults;
  std::set<LineEvent::Kind> told;

  void add(const CampaignRun& run) {
    recoveries += run.recoveries();
    registers += run.registers();
    demanded += run.demanded();
    faults.merge(std::set(run.kinds()));
    told.merge(run.told_kinds());
  }
};

TEST(RecoveryCampaign, EverybodyIsBackAndNobodyIsAccusedWrongly) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(40U));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  CampaignSum sum;
  std::size_t settled_bytes = 0;
  unsigned failures = 0;
  for (unsigned i = 0; i < runs; ++i) {
    {
      CampaignRun run(first + i);
      const auto wrong = run.execute();
      EXPECT_EQ(wrong, "") << "seed " << first + i;
      if (!wrong.empty() && ++failures == 10) FAIL() << "enough";
      if (wrong.empty()) sum.add(run);
    }
    // After the first runs all persistent memory has been allocated.
    if (i == 9) settled_bytes = mallinfo2().uordblks;
    if (i % 100 == 99 || i + 1 == runs) {
      std::cout << i + 1 << " runs, " << sum.recoveries << " recoveries, " << sum.registers << " registers put right, "
                << sum.demanded << " sentences that had to be told" << std::endl;
    }
  }
  EXPECT_GT(sum.recoveries, runs / 4);
  if (runs >= 40) {
    EXPECT_EQ(sum.faults.size(), slaves::kFaultKindCount) << "not every kind of fault has come";
    EXPECT_GT(sum.demanded, runs / 2) << "too little is decided";
    using Kind = LineEvent::Kind;
    for (const auto kind :
         {Kind::kLeftOp, Kind::kGone, Kind::kRecovered, Kind::kRecoveryFailed, Kind::kRegistersRestored})
      EXPECT_TRUE(sum.told.contains(kind)) << static_cast<int>(kind);
  }
  if (runs > 10) {
    EXPECT_LT(mallinfo2().uordblks, settled_bytes + 64 * 1024) << "memory that no run has given back";
  }
}

}  // namespace
}  // namespace driveline::bus_test
