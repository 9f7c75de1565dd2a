// The faults of the emulated line, several at a time, again and again from different seeds: nobody may be accused who
// has nothing to do with it, and everybody must be back in the end.
//
// DRIVELINE_CAMPAIGN_RUNS sets the number of runs (default 40), DRIVELINE_CAMPAIGN_SEED the first seed.
#include <gmock/gmock.h>
#include <malloc.h>

#include <cstdlib>
#include <iostream>
#include <random>
#include <set>

#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineEvent;
using ecat_master::LineSupervisor;
using ecat_master::MotionPhase;
using slaves::Fault;
using slaves::FaultKind;
using slaves::FaultWay;

unsigned environment(const char* name, unsigned otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

/// One run of the campaign.
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

  /// What is wrong in the end, empty: nothing.
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
    // Time for the last round of register reading, and for what it finds.
    live(milliseconds{50});
    if (!settle()) return "stuck after a look at the registers: " + faults_ + told();
    if (const auto lost = changed_register(); !lost.empty()) return lost + " after: " + faults_ + told();
    if (const auto wrong = wrong_sentence(); !wrong.empty()) return wrong + " after: " + faults_ + told();
    return drive_on();
  }
  [[nodiscard]] std::size_t kinds() const noexcept { return kinds_.size(); }
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

  void affect_from(std::size_t slave) {
    for (; slave < drives_.size(); ++slave) affected_.insert(slave);
  }

  void inject() {
    Fault fault;
    fault.kind = static_cast<FaultKind>(pick(0, slaves::kFaultKindCount - 1));
    fault.slave = static_cast<std::uint16_t>(pick(0, drives_.size() - 1));
    fault.duration = milliseconds{static_cast<int>(pick(5, 200))};
    fault.seed = static_cast<std::uint32_t>(pick(1, 1'000'000));
    fault.time = microseconds{static_cast<int>(pick(50, 5000))};
    fault.way = pick(0, 1) == 0 ? FaultWay::kOut : FaultWay::kBack;
    switch (fault.kind) {
      case FaultKind::kDrop:
      case FaultKind::kDamage:
        // Long enough for watchdogs, or a few frames.
        fault.chance = pick(0, 2) == 0 ? 1.0 : 0.2;
        affect_from(0);
        break;
      case FaultKind::kDelay:
        fault.count = static_cast<std::uint32_t>(pick(1, 30));
        fault.time = microseconds{static_cast<int>(pick(20, 400))};
        break;
      case FaultKind::kCorrupt:
        // The way back deceives the master only; what reaches slaves may do anything to them, registers included.
        fault.count = static_cast<std::uint32_t>(pick(1, 20));
        fault.bits = static_cast<std::uint32_t>(pick(1, 4));
        affect_from(0);
        break;
      case FaultKind::kPowerOff:
        affect_from(fault.slave);
        break;
      case FaultKind::kCableBreak:
        // Port 0 leads towards the master.
        fault.port = 0;
        affect_from(fault.slave);
        break;
      case FaultKind::kShortWorkingCounter:
        // It gets no outputs meanwhile, and its watchdog notices.
        affected_.insert(fault.slave);
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
    if (!drives_.line().inject(fault)) return;
    kinds_.insert(fault.kind);
    faults_ += std::string(slaves::fault_kind_row(fault.kind).name) + " slave " + std::to_string(fault.slave) + ", ";
  }

  /// All faults over: everybody must come back.
  bool settle() {
    const auto end = drives_.clock.now() + std::chrono::seconds{30};
    while (!drives_.line().faults().active().empty() && drives_.clock.now() < end) live(milliseconds{20});
    for (const auto slave : reload_) {
      // An EEPROM that was found damaged is loaded again when the slave is switched on.
      affect_from(slave);
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
  /// The registers that make up the configuration of all slaves, without what slaves and mailboxes change in them.
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
      if (event.slave >= drives_.size()) return "names a slave that is not there: " + text;
      if (affected_.count(event.slave) == 0) return "accuses slave " + std::to_string(event.slave) + ": " + text;
      const bool back = event.kind == LineEvent::Kind::kRecovered;
      const bool lost = event.kind == LineEvent::Kind::kGone || event.kind == LineEvent::Kind::kLeftOp;
      if (back && out.erase(event.slave) == 0) return "comes back without having left: " + text;
      if (lost && !out.insert(event.slave).second) return "leaves twice: " + text;
      // Also as the reason why it has left.
      if (event.kind == LineEvent::Kind::kRegistersChanged) out.insert(event.slave);
      if (event.kind == LineEvent::Kind::kRecoveryFailed && out.count(event.slave) == 0)
        return "fails at nothing: " + text;
    }
    return out.empty() ? std::string() : "never told that slave " + std::to_string(*out.begin()) + " is back";
  }

  /// The line does its work as if nothing had been.
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
  std::set<std::size_t> affected_;
  std::set<std::size_t> reload_;
  std::vector<Byte> before_;
  std::set<FaultKind> kinds_;
  std::string faults_;
};

TEST(RecoveryCampaign, EverybodyIsBackAndNobodyIsAccusedWrongly) {
  const auto runs = environment("DRIVELINE_CAMPAIGN_RUNS", 40);
  const auto first = environment("DRIVELINE_CAMPAIGN_SEED", 1);
  std::uint64_t recoveries = 0;
  std::uint64_t registers = 0;
  std::size_t settled_bytes = 0;
  unsigned failures = 0;
  for (unsigned i = 0; i < runs; ++i) {
    {
      CampaignRun run(first + i);
      const auto wrong = run.execute();
      EXPECT_EQ(wrong, "") << "seed " << first + i;
      if (!wrong.empty() && ++failures == 10) FAIL() << "enough";
      if (wrong.empty()) recoveries += run.recoveries();
      if (wrong.empty()) registers += run.registers();
    }
    // After the first runs everything that stays has been allocated once.
    if (i == 9) settled_bytes = mallinfo2().uordblks;
    if (i % 100 == 99 || i + 1 == runs) {
      std::cout << i + 1 << " runs, " << recoveries << " recoveries, " << registers << " registers put right"
                << std::endl;
    }
  }
  EXPECT_GT(recoveries, runs / 4);
  if (runs > 10) {
    EXPECT_LT(mallinfo2().uordblks, settled_bytes + 64 * 1024) << "memory that no run has given back";
  }
}

}  // namespace
}  // namespace driveline::bus_test
