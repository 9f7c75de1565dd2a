// Recovery of nodes by the CANopen master: what happens to them, to the adapter and to single frames, several at a time
// and one by one, repeated with different seeds. Afterwards every node is Operational and configured as planned, or
// told as lost; each event has its deed, with the true reason (recovery_deeds.hpp).
// DRIVELINE_CAMPAIGN_RUNS sets the number of runs, DRIVELINE_CAMPAIGN_SEED the first seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <set>

#include "driveline/canopen_wire/nmt.hpp"
#include "recovery_deeds.hpp"
#include "recovery_line.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using canopen::MasterEvent;
using canopen::NmtCommand;
using canopen::NodePhase;
using slaves::can::FrameFault;
using slaves::can::FrameFaultKind;
using namespace std::chrono_literals;

/// What the runs have met, so that a campaign that meets nothing is a failure.
struct RecoveryCoverage {
  std::array<unsigned, kDeedKinds> alone{};  ///< deeds beside which nothing else was done
  std::set<MasterEvent::Kind> told;
  std::uint64_t recoveries = 0;
  unsigned left_behind = 0;  ///< nodes that stayed away
};

class CanRecoveryRun {
 public:
  CanRecoveryRun(unsigned seed, RecoveryCoverage& coverage)
      : random_(seed), line_(random_), deeds_(nodes_of(line_)), coverage_(coverage) {}

  /// Returns the finding, empty: none.
  std::string execute() {
    if (auto failure = line_.start(); !failure.empty()) return "start: " + failure;
    if (!line_.fine()) return "is not in operation at the start";
    for (const auto step : {&CanRecoveryRun::mess, &CanRecoveryRun::one_by_one, &CanRecoveryRun::leave_one_behind,
                            &CanRecoveryRun::judge}) {
      if (auto finding = (this->*step)(); !finding.empty()) return finding + ", after\n" + deeds_.text() + told();
    }
    const auto down = line_.shut_down();
    return down.empty() ? down : "on the way down: " + down;
  }

 private:
  static std::vector<DeedNode> nodes_of(RecoveryLine& line) {
    std::vector<DeedNode> nodes;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const auto& control = line.plan(i).error_control;
      nodes.push_back({control.master_tolerance.count() > 0, control.guard_time.count() > 0});
    }
    return nodes;
  }
  [[nodiscard]] std::size_t pick(std::size_t from, std::size_t to) {
    return std::uniform_int_distribution<std::size_t>(from, to)(random_);
  }
  [[nodiscard]] milliseconds time(std::size_t from_ms, std::size_t to_ms) {
    return milliseconds{static_cast<std::int64_t>(pick(from_ms, to_ms))};
  }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : line_.history()) all += line_.sentence(event) + "\n";
    return all;
  }

  /// Something that goes on, and how it ends.
  struct Harm {
    Deed deed;
    std::function<void()> end;
  };

  [[nodiscard]] Deed any_deed() {
    Deed deed;
    deed.kind = static_cast<DeedKind>(pick(0, kDeedKinds - 1));
    deed.node = pick(0, line_.size() - 1);
    if (deed.kind == DeedKind::kOtherDevice) deed.node = 0;
    if (deed.kind == DeedKind::kFault) {
      constexpr std::array kFaults{slaves::msd::Fault::kEncoder, slaves::msd::Fault::kMotorTemperature,
                                   slaves::msd::Fault::kOvercurrent};
      deed.fault = kFaults[pick(0, kFaults.size() - 1)];
      deed.node = pick(0, line_.size() - 2);  // the last one is no drive
      // A drive in Fault tells of no other one.
      if (line_.drive(deed.node)->fault()) deed.kind = DeedKind::kReset;
    }
    deed.begin = line_.now();
    return deed;
  }

  void lose(FrameFault fault, Harm& harm) {
    fault.kind = FrameFaultKind::kLost;
    fault.mask = canopen::Identifier::kBaseMask;
    fault.count = FrameFault::kUnlimited;
    fault.number = ++faults_;
    line_.bus().inject(fault);
    harm.end = [this, number = fault.number] { line_.bus().withdraw(number); };
  }
  void command(NmtCommand command, const Deed& deed) {
    line_.stranger().send_at(line_.now(), canopen::NmtRequest{command, line_.id(deed.node)}.frame());
  }
  /// A node that starts anew.
  void restart(std::size_t number) {
    line_.node(number).set_power(false);
    line_.node(number).set_power(true);
  }

  /// P 153 acknowledges the fault of a drive; a drive without supply keeps it.
  void acknowledge(std::size_t number) {
    static_cast<void>(line_.master().download(number, {0x2099, 0}, std::array{std::byte{1}}));
  }

  Harm begin(const Deed& deed) {
    constexpr std::size_t kMaster = 0;  // its place on the bus
    Harm harm{deed, [] {}};
    auto& node = line_.node(deed.node);
    switch (deed.kind) {
      case DeedKind::kPowerOff:
        node.set_power(false);
        harm.end = [&node] { node.set_power(true); };
        break;
      case DeedKind::kNodeBusOff:
        node.device().controller()->fail(line_.now());
        harm.end = [this, number = deed.node] { restart(number); };
        break;
      case DeedKind::kAdapterBusOff:
        line_.port().controller().fail(line_.now());
        harm.end = [this] { line_.port().controller().recover(line_.now()); };
        break;
      case DeedKind::kHeartbeatLost:
        lose({.identifier = 0x700U + line_.id(deed.node), .receiver = kMaster}, harm);
        break;
      case DeedKind::kMasterUnheard:
        lose({.identifier = 0x700U + RecoveryLine::kMasterId}, harm);
        break;
      case DeedKind::kReset:
        command(pick(0, 1) == 0 ? NmtCommand::kResetNode : NmtCommand::kResetCommunication, deed);
        break;
      case DeedKind::kStop:
        command(NmtCommand::kStop, deed);
        break;
      case DeedKind::kPreOperational:
        command(NmtCommand::kEnterPreOperational, deed);
        break;
      case DeedKind::kSilentSdo:
        lose({.identifier = 0x580U + line_.id(deed.node), .receiver = kMaster}, harm);
        restart(deed.node);
        break;
      case DeedKind::kOtherDevice:
        node.set_power(false);
        line_.other_device().set_power(true);
        harm.end = [this, &node] {
          line_.other_device().set_power(false);
          node.set_power(true);
        };
        break;
      case DeedKind::kFault:
        line_.drive(deed.node)->raise(deed.fault);
        harm.end = [this, number = deed.node] { acknowledge(number); };
        break;
      case DeedKind::kCount:
        break;
    }
    return harm;
  }
  void end(Harm& harm) {
    harm.end();
    harm.deed.end = line_.now();
    deeds_.add(harm.deed);
  }

  /// Lets the line live until all nodes are back.
  [[nodiscard]] bool settle(std::optional<std::size_t> except = {}) {
    const auto latest = line_.now() + 5s;
    do {
      line_.live(20ms);
    } while (!line_.fine(except) && line_.now() < latest);
    return line_.fine(except);
  }

  /// Lets all consequences of the deeds so far show, and lets the line live until all nodes are back. A node that did
  /// not hear the master leaves Operational as late as its tolerance after that: until then it looks fine.
  [[nodiscard]] bool come_to_rest() {
    line_.live(RecoveryLine::kMasterTolerance);
    return settle();
  }

  /// Several deeds that overlap. The same is not done twice at a time.
  std::string mess() {
    std::vector<Harm> harms;
    const std::size_t count = pick(2, 4);
    for (std::size_t i = 0; i < count; ++i) {
      const auto deed = any_deed();
      const bool goes_on = std::any_of(harms.begin(), harms.end(), [&](const Harm& harm) {
        return harm.deed.node == deed.node || harm.deed.kind == deed.kind;
      });
      if (!goes_on) harms.push_back(begin(deed));
      line_.live(time(4, 90));
      if (!harms.empty() && pick(0, 1) == 0) {
        end(harms.front());
        harms.erase(harms.begin());
      }
    }
    for (auto& harm : harms) end(harm);
    return settle() ? "" : "is stuck";
  }

  /// Deeds beside which nothing else is done, for so long that they are noticed.
  std::string one_by_one() {
    for (int i = 0; i < 2; ++i) {
      if (!come_to_rest()) return "is stuck";
      const auto before = line_.history().size();
      auto harm = begin(any_deed());
      line_.live(time(120, 300));
      end(harm);
      if (!settle()) return std::string("is stuck after a single deed");
      line_.live(40ms);
      const RecoveryDeeds::History since(line_.history().begin() + static_cast<std::ptrdiff_t>(before),
                                         line_.history().end());
      if (!RecoveryDeeds::told(harm.deed, since)) return std::string("never told: ") + to_text(harm.deed.kind);
      ++coverage_.alone[static_cast<std::size_t>(harm.deed.kind)];
      for (const auto& event : since) {
        const bool of_all =
            harm.deed.kind == DeedKind::kAdapterBusOff || harm.deed.kind == DeedKind::kMasterUnheard || event.id == 0;
        if (!of_all && event.node != harm.deed.node) return "accuses another node: " + line_.sentence(event);
      }
    }
    return {};
  }

  /// A node that stays away: the others go on, and it is told as lost, once.
  std::string leave_one_behind() {
    if (pick(0, 2) != 0) return {};
    if (!come_to_rest()) return "is stuck";
    const auto before = line_.history().size();
    Deed deed;
    deed.kind = DeedKind::kPowerOff;
    deed.node = pick(0, line_.size() - 1);
    deed.begin = line_.now();
    auto harm = begin(deed);
    line_.live(400ms);
    const auto name = line_.plan(deed.node).name;
    if (line_.master().node(deed.node).phase != NodePhase::kLost) return name + " is away and not lost";
    if (!line_.fine(deed.node)) return "others than " + name + " are not in operation";
    if (line_.master().all_operational()) return name + " is away and counts as operational";
    const auto lost =
        std::count_if(line_.history().begin() + static_cast<std::ptrdiff_t>(before), line_.history().end(),
                      [](const MasterEvent& event) { return event.kind == MasterEvent::Kind::kNodeLost; });
    if (lost != 1) return "told " + std::to_string(lost) + " times that " + name + " is lost";
    ++coverage_.left_behind;
    end(harm);
    return settle() ? "" : name + " does not come back";
  }

  std::string judge() {
    std::vector<bool> out(line_.size());
    std::uint64_t back = 0;
    for (const auto& event : line_.history()) {
      coverage_.told.insert(event.kind);
      if (!deeds_.explains(event)) return "nothing was done for that: " + line_.sentence(event);
      if (event.kind == MasterEvent::Kind::kNodeLost && event.waited_ms != RecoveryLine::kPatience.count())
        return "waited for another time: " + line_.sentence(event);
      const bool leaves = event.kind == MasterEvent::Kind::kNodeLost || event.kind == MasterEvent::Kind::kWrongState ||
                          event.kind == MasterEvent::Kind::kNodeRebooted;
      if (leaves) out[event.node] = true;
      if (event.kind == MasterEvent::Kind::kRecoveryFailed && !out[event.node])
        return "fails at nothing: " + line_.sentence(event);
      if (event.kind != MasterEvent::Kind::kNodeBack) continue;
      ++back;
      if (!out[event.node]) return "comes back without having left: " + line_.sentence(event);
      out[event.node] = false;
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (out[i]) return "never told that " + line_.plan(i).name + " is back";
    }
    coverage_.recoveries += back;
    if (back != line_.master().recoveries())
      return "counts " + std::to_string(line_.master().recoveries()) + " recoveries, not " + std::to_string(back);
    if (line_.master().cycle()->bad_cycles() != 0) return "has bad cycles";
    return line_.changed_object();
  }

  std::mt19937 random_;
  RecoveryLine line_;
  RecoveryDeeds deeds_;
  RecoveryCoverage& coverage_;
  std::uint32_t faults_ = 0;
};

/// Number of runs that meet everything.
constexpr unsigned kRecoveringRuns = 60;

TEST(CanRecoveryCampaign, EveryNodeIsBackOrToldAsLostAndNothingIsToldWrongly) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(kRecoveringRuns));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  constexpr int kEnough = 10;  // failures to report
  RecoveryCoverage coverage;
  int failures = 0;
  for (unsigned seed = first; seed < first + runs && failures < kEnough; ++seed) {
    const auto finding = CanRecoveryRun(seed, coverage).execute();
    EXPECT_EQ(finding, "") << "seed " << seed;
    failures += finding.empty() ? 0 : 1;
    if ((seed - first) % 1000 == 999) std::printf("%u runs\n", seed - first + 1);
  }
  if (runs < kRecoveringRuns || failures > 0) return;
  for (std::size_t i = 0; i < kDeedKinds; ++i)
    EXPECT_GT(coverage.alone[i], 0U) << to_text(static_cast<DeedKind>(i)) << ": never alone";
  using Kind = MasterEvent::Kind;
  for (const auto kind : {Kind::kNodeLost, Kind::kNodeBack, Kind::kNodeRebooted, Kind::kWrongState,
                          Kind::kRecoveryFailed, Kind::kEmergency, Kind::kOtherMaster, Kind::kBusOff, Kind::kBusBack})
    EXPECT_TRUE(coverage.told.contains(kind)) << static_cast<int>(kind);
  EXPECT_GT(coverage.recoveries, 2U * runs);
  EXPECT_GT(coverage.left_behind, runs / 6);
}

}  // namespace
}  // namespace driveline::bus_test
