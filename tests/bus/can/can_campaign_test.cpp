// Faults of a CAN bus, several at a time, repeated with different seeds: afterwards every drive is in a state that its
// manual names, and what it reports about itself agrees; a reset and a start make it operational again.
// DRIVELINE_CAMPAIGN_RUNS sets the number of runs (default 60), DRIVELINE_CAMPAIGN_SEED the first seed.
#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cmath>
#include <iostream>
#include <numbers>
#include <optional>
#include <set>

#include "campaign_line.hpp"
#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "support/campaign.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::bus_test {
namespace {

using canopen::NmtCommand;
using canopen::NmtState;
using slaves::PowerState;
using slaves::can::ErrorState;
using slaves::msd::Fault;
using namespace std::chrono_literals;

constexpr std::uint16_t kErrorPassive = 0x8120;
constexpr unsigned kStackBits = 0x11;  ///< of 1001h: generic, communication

/// What the runs have met, so that a campaign that meets nothing is a failure.
struct CampaignCoverage {
  std::array<unsigned, static_cast<std::size_t>(Disturbance::kCount)> disturbances{};
  std::set<Fault> faults;
  std::set<NmtState> states;
  unsigned drives_bus_off = 0;
  unsigned devices_bus_off = 0;
  unsigned passive = 0;
  unsigned recovered = 0;  ///< drives
};

/// Whether a status word has the bits of a state (MSD manual Table 11.8).
bool has_bits_of(std::uint64_t status, PowerState state) {
  switch (state) {
    case PowerState::kNotReadyToSwitchOn:
      return (status & 0x4F) == 0x00;
    case PowerState::kSwitchOnDisabled:
      return (status & 0x4F) == 0x40;
    case PowerState::kReadyToSwitchOn:
      return (status & 0x6F) == 0x21;
    case PowerState::kSwitchedOn:
      return (status & 0x6F) == 0x23;
    case PowerState::kOperationEnabled:
      return (status & 0x6F) == 0x27;
    case PowerState::kQuickStopActive:
      return (status & 0x6F) == 0x07;
    case PowerState::kFaultReactionActive:
      return (status & 0x4F) == 0x0F;
    case PowerState::kFault:
      return (status & 0x4F) == 0x08;
  }
  return false;
}

bool is_of_the_bus(Fault fault) {
  return fault >= Fault::kBusOff && fault <= Fault::kCommunicationEnded;
}

/// A run of the campaign.
class CanCampaignRun {
 public:
  CanCampaignRun(unsigned seed, const std::array<std::string, 2>& files, CampaignCoverage& coverage, int pieces = 1)
      : line_(seed, files, pieces), coverage_(coverage) {}

  /// Returns the finding, empty: none.
  std::string execute() {
    const std::size_t count = line_.pick(2, 5);
    for (std::size_t i = 0; i < count; ++i) {
      planned_.push_back(static_cast<Disturbance>(line_.pick(0, static_cast<std::size_t>(Disturbance::kCount) - 1)));
    }
    for (const auto step :
         {&CanCampaignRun::start, &CanCampaignRun::disturb, &CanCampaignRun::settle, &CanCampaignRun::judge_all,
          &CanCampaignRun::recover, &CanCampaignRun::move_again, &CanCampaignRun::report_a_fault}) {
      if (auto finding = (this->*step)(); !finding.empty()) return finding + ", after: " + planned();
    }
    return {};
  }
  /// A sum over all frames and their times, and over where the drives are.
  [[nodiscard]] std::uint64_t sum() {
    std::uint64_t sum = line_.listener().sum();
    for (const auto& one : line_.drives()) {
      sum = sum * 31 + std::bit_cast<std::uint64_t>(one.drive->core().position_rad());
    }
    return sum;
  }

 private:
  [[nodiscard]] std::string planned() const {
    std::string text;
    for (const Disturbance one : planned_) text += (text.empty() ? "" : ", ") + std::string(to_text(one));
    return text;
  }
  /// What the communication of a device is like, for findings.
  static std::string facts_of(const slaves::cia301::Device& device) {
    const auto& controller = *device.controller();
    return " (NMT state " + std::to_string(static_cast<int>(device.state())) + ", TEC " +
           std::to_string(controller.errors().transmit()) + ", REC " + std::to_string(controller.errors().receive()) +
           ", " + std::to_string(controller.options().bit_rate) + " bit/s, node-ID " +
           std::to_string(device.node_id()) + ")";
  }
  static std::string named(std::uint8_t node, const std::string& what) {
    return "node " + std::to_string(node) + ' ' + what;
  }

  /// Settings that differ between the drives, and power on.
  std::string start() {
    if (auto finding = line_.live(10ms); !finding.empty()) return finding;
    for (auto& one : line_.drives()) {
      bool good = true;
      const auto set = [&](std::uint16_t index, std::uint8_t sub, std::uint32_t value, std::size_t size) {
        good = good && line_.write(one.node, index, sub, value, size) == 0;
      };
      one.guarded = line_.pick(0, 3) == 0;
      if (one.guarded) {  // MSD manual 8.4: no heartbeat beside it; the master asks every 15 ms
        set(0x1017, 0, 0, 2);
        set(0x100C, 0, 10, 2);
        set(0x100D, 0, 3, 1);
      } else if (one.drive->core().variant() == slaves::msd::Variant::kMsd && line_.pick(0, 1) == 0) {
        set(0x1016, 1, 0x007F'002D, 4);  // the master's heartbeat, 45 ms
      }
      if (line_.pick(0, 2) == 0) set(0x280E, 0, 30, 4);  // SYNC, 30 ms
      set(0x6060, 0, 3, 1);
      if (!good) return named(one.node, "refuses its settings");
    }
    for (const auto& one : line_.devices()) {
      if (line_.write(one->node, 0x1017, 0, 20, 2) != 0) return named(one->node, "refuses its heartbeat");
    }
    return switch_on();
  }

  std::string switch_on() {
    line_.send(canopen::NmtRequest{NmtCommand::kStart, 0}.frame());
    if (auto finding = line_.live(4ms); !finding.empty()) return finding;
    for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) {
      line_.send_setpoints(word, 0.0);
      if (auto finding = line_.live(4ms); !finding.empty()) return finding;
    }
    for (const auto& one : line_.drives()) {
      if (one.drive->core().state() != PowerState::kOperationEnabled || one.drive->core().fault()) {
        return named(one.node, "cannot be switched on");
      }
    }
    for (const auto& one : line_.devices()) {
      if (one->device.state() != NmtState::kOperational) return named(one->node, "is not operational");
    }
    return {};
  }

  std::string disturb() {
    line_.command(true);
    std::string finding = line_.live(20ms);
    for (const Disturbance one : planned_) {
      ++coverage_.disturbances[static_cast<std::size_t>(one)];
      line_.begin(one);
      // A wire that is held dominant is off for everybody within a millisecond.
      const std::size_t longest = one == Disturbance::kDominant || one == Disturbance::kBabble ? 4 : 25;
      const auto found = line_.live(std::chrono::milliseconds{static_cast<int>(line_.pick(1, longest))});
      if (finding.empty()) finding = found;
      if (line_.pick(0, 1) == 0) line_.end();
    }
    line_.end();
    line_.command(false);
    return finding;
  }

  std::string settle() {
    if (!line_.use_up_faults()) return "a fault of a frame never comes";
    // A babbled SYNC leaves 64 PDOs of each drive in the queues: 21 ms of three drives.
    if (auto finding = line_.live(40ms); !finding.empty()) return finding;
    line_.listener().forget();
    return line_.live(kListening);
  }

  std::string judge_all() {
    for (auto& one : line_.drives()) {
      if (auto finding = judge(one); !finding.empty()) return named(one.node, finding);
    }
    for (const auto& one : line_.devices()) {
      if (auto finding = judge(*one); !finding.empty()) return named(one->node, finding);
    }
    return {};
  }

  /// What each device must be: a state of CiA 301, off the bus not Operational, and heartbeats that say so.
  template <typename Device>
  std::string judge_communication(const Device& one, const slaves::cia301::Device& device, bool asked) {
    const NmtState state = device.state();
    coverage_.states.insert(state);
    if (state == NmtState::kInitialising) return "is still initialising";
    if (one.bus_off() && state == NmtState::kOperational) return "is operational in bus off";
    if (one.bus_off() != device.persists(slaves::cia301::CommunicationEvent::kBusOff)) return "is wrong about bus off";
    const auto& heard = line_.listener().of(one.node);
    const auto period_ms = one.value(0x1017);
    if (one.bus_off()) return heard.states + heard.boot_ups == 0 ? "" : "is heard in bus off";
    if (heard.boot_ups != 0) return "starts by itself";
    if (period_ms == 0 && !asked) return heard.states == 0 ? "" : "has a heartbeat that nobody wants";
    const std::uint64_t expected = kListening.count() / (period_ms != 0 ? period_ms : 15);
    if (heard.states + 1 < expected || heard.states > expected + 1) {
      return "is heard " + std::to_string(heard.states) + " times, not " + std::to_string(expected);
    }
    if (heard.last_state != static_cast<std::uint8_t>(state)) return "tells another state than its own";
    return {};
  }

  std::string judge(const CampaignDrive& one) {
    const auto& core = one.drive->core();
    if (auto finding = judge_communication(one, one.drive->device(), one.guarded); !finding.empty()) return finding;
    const auto fault = core.fault();
    if (one.bus_off()) ++coverage_.drives_bus_off;
    if (fault) coverage_.faults.insert(*fault);
    if (one.bus_off() && !fault) return "is bus off without a fault";
    if (fault && !is_of_the_bus(*fault)) return "has a fault that nobody caused: " + std::string(facts(*fault).text);
    // P 2060 has the numbers of the heartbeat (MSD manual Table 6.5).
    if (one.value(0x280C) != static_cast<std::uint8_t>(one.drive->device().state())) return "shows another P 2060";
    if (!has_bits_of(one.value(0x6041), core.state())) return "has a status word of another state";
    const bool in_fault = core.state() == PowerState::kFault;
    if (in_fault != fault.has_value()) return "is in the state Fault without one, or the other way round";
    if (core.power_on() && one.drive->device().state() != NmtState::kOperational) return "is on, and not operational";
    return judge_objects(one, fault);
  }

  /// 603Fh, 1001h and 1003h say the same. The stack adds "error passive" to the last two.
  std::string judge_objects(const CampaignDrive& one, std::optional<Fault> fault) {
    const unsigned code = fault ? facts(*fault).error_code : 0U;
    const unsigned needed = fault ? facts(*fault).error_register | 1U : 0U;
    const bool active = one.drive->device().controller()->errors().state() == ErrorState::kActive;
    if (!active) ++coverage_.passive;
    const auto reg = static_cast<unsigned>(one.value(0x1001));
    if (one.value(0x603F) != code) return "has another 603Fh than its fault";
    if ((reg & needed) != needed || (reg & ~(needed | (active ? 0U : kStackBits))) != 0) {
      return "has 1001h = " + std::to_string(reg) + " with the fault " + std::to_string(code);
    }
    const auto newest = static_cast<unsigned>(one.value(0x1003, 1) & 0xFFFF);
    if (fault && newest != code && newest != kErrorPassive) return "has not its fault in 1003h";
    return {};
  }

  std::string judge(const CampaignDevice& one) {
    if (auto finding = judge_communication(one, one.device, false); !finding.empty()) return finding;
    if (one.bus_off()) ++coverage_.devices_bus_off;
    const bool active = one.device.controller()->errors().state() == ErrorState::kActive;
    if (active && one.value(0x1001) != 0) return "has an error that nobody caused";
    return {};
  }

  /// A reset by the master, or a restart where a device does not hear it.
  std::string recover() {
    line_.listener().forget();
    for (auto& one : line_.drives()) {
      one.guarded = false;  // the stored heartbeat is back
      if (one.bus_off()) one.drive->restart();
    }
    for (const auto& one : line_.devices()) {
      if (one->bus_off()) one->device.power_on();
    }
    line_.send(canopen::NmtRequest{NmtCommand::kResetNode, 0}.frame());
    if (auto finding = line_.live(10ms); !finding.empty()) return finding;
    for (const auto& one : line_.drives()) {
      if (line_.listener().of(one.node).boot_ups == 0)
        return named(one.node, "sends no boot-up message" + facts_of(one.drive->device()));
      if (one.drive->device().state() != NmtState::kPreOperational) return named(one.node, "is not pre-operational");
      if (one.drive->core().fault()) return named(one.node, "has a fault after its reset");
      // A frame that ends in an error, as another node starts again, may make it error passive once more.
      const bool active = one.drive->device().controller()->errors().state() == ErrorState::kActive;
      if (active && one.value(0x1001) != 0) return named(one.node, "has an error after its reset");
      if (line_.write(one.node, 0x6060, 0, 3, 1) != 0) return named(one.node, "does not answer after its reset");
    }
    for (const auto& one : line_.devices()) {
      if (line_.listener().of(one->node).boot_ups == 0)
        return named(one->node, "sends no boot-up message" + facts_of(one->device));
    }
    return switch_on();
  }

  std::string move_again() {
    constexpr double kTurns = 1.0;
    line_.send_setpoints(0x0F, kTurns);
    if (auto finding = line_.live(50ms); !finding.empty()) return finding;
    for (const auto& one : line_.drives()) {
      const double off = one.drive->core().velocity_rad_s() - kTurns * 2.0 * std::numbers::pi;
      if (!(std::abs(off) < 0.3)) return named(one.node, "does not follow its setpoint");
      ++coverage_.recovered;
    }
    return {};
  }

  /// EMCY with the numbers of the fault, and its end when it is acknowledged.
  std::string report_a_fault() {
    auto& one = line_.drives()[line_.pick(0, line_.drives().size() - 1)];
    line_.listener().forget();
    one.drive->core().raise(Fault::kEncoder);
    if (auto finding = line_.live(20ms); !finding.empty()) return finding;
    const auto& heard = line_.listener().of(one.node).emergencies;
    const auto first = heard.empty() ? std::nullopt : canopen::Emergency::decode(heard.front().payload());
    if (!first || first->code != 0x7300 || first->manufacturer[0] != std::byte{10} ||
        first->manufacturer[1] != std::byte{1}) {
      return named(one.node, "does not tell of its fault");
    }
    if (line_.write(one.node, 0x2099, 0, 1, 1) != 0) return named(one.node, "takes no acknowledgement");
    if (auto finding = line_.live(3ms); !finding.empty()) return finding;
    // Error passive is another error, behind whose end the message comes.
    if (one.drive->device().controller()->errors().state() != ErrorState::kActive) return {};
    if (one.value(0x1001) != 0) return named(one.node, "has an error behind its acknowledgement");
    const auto last = canopen::Emergency::decode(line_.listener().of(one.node).emergencies.back().payload());
    return last && *last == canopen::Emergency{} ? "" : named(one.node, "does not tell that its fault has gone");
  }

  static constexpr std::chrono::milliseconds kListening{60};

  CampaignLine line_;
  CampaignCoverage& coverage_;
  std::vector<Disturbance> planned_;
};

class CanCampaign : public ::testing::Test {
 protected:
  CanCampaign() {
    store_parameters(slaves::msd::Variant::kMsd, files_[0]);
    store_parameters(slaves::msd::Variant::kServoOne, files_[1]);
  }
  test::TemporaryFolder folder_;
  std::array<std::string, 2> files_{(folder_.path / "msd.txt").string(), (folder_.path / "servoone.txt").string()};
};

/// Number of runs that meet everything.
constexpr unsigned kCoveringRuns = 200;

void expect_everything_met(const CampaignCoverage& met, unsigned runs) {
  for (std::size_t i = 0; i < met.disturbances.size(); ++i) {
    EXPECT_GT(met.disturbances[i], 0U) << to_text(static_cast<Disturbance>(i));
  }
  EXPECT_GT(met.drives_bus_off, 0U);
  EXPECT_GT(met.devices_bus_off, 0U);
  EXPECT_GT(met.passive, 0U);
  EXPECT_GT(met.recovered, runs);
  for (const Fault fault :
       {Fault::kBusOff, Fault::kHeartbeat, Fault::kLifeGuarding, Fault::kTelegramFailure, Fault::kCommunicationEnded}) {
    EXPECT_TRUE(met.faults.contains(fault)) << facts(fault).text;
  }
  EXPECT_EQ(met.states.size(), 3U) << "Stopped, Operational, Pre-operational";
}

TEST_F(CanCampaign, EveryDriveIsInANamedStateAndOperationalAfterAReset) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(kCoveringRuns));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  constexpr int kEnough = 10;  // failures to report
  CampaignCoverage coverage;
  int failures = 0;
  for (unsigned seed = first; seed < first + runs && failures < kEnough; ++seed) {
    CanCampaignRun run(seed, files_, coverage);
    const auto finding = run.execute();
    EXPECT_EQ(finding, "") << "seed " << seed;
    failures += finding.empty() ? 0 : 1;
    if ((seed - first) % 1000 == 999) std::cout << seed - first + 1 << " runs" << std::endl;
  }
  if (runs >= kCoveringRuns && failures == 0) expect_everything_met(coverage, runs);
}

/// The same frames at the same nanosecond, in steps of another size, too.
TEST_F(CanCampaign, ASeedGivesTheSameFramesAtTheSameNanoseconds) {
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  std::set<std::uint64_t> sums;
  const unsigned runs = test::share_of(12U);
  for (unsigned seed = first; seed < first + runs; ++seed) {
    CampaignCoverage coverage;
    CanCampaignRun once(seed, files_, coverage);
    CanCampaignRun again(seed, files_, coverage, 3);
    static_cast<void>(once.execute());
    static_cast<void>(again.execute());
    EXPECT_EQ(once.sum(), again.sum()) << "seed " << seed;
    sums.insert(once.sum());
  }
  EXPECT_EQ(sums.size(), runs) << "other seeds give others";
}

}  // namespace
}  // namespace driveline::bus_test
