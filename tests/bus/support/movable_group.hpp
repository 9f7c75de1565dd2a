#pragma once

#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "edited_line.hpp"

namespace driveline::bus_test {

/// A line with two positions for a hot-connect group of two drives, which can be plugged in at either:
///
///   master - base (0) - mid (3) - position B: head (4) - follower (5)
///               |
///            port 3 - position A: head (1) - follower (2)
///
/// The plans are base, mid, head and follower: slaves 0 to 3 of a master that starts without the group.
class MovableGroup {
 public:
  static constexpr std::uint16_t kAlias = 0x0207;
  static constexpr std::size_t kHead = 2;      ///< index of its plan
  static constexpr std::size_t kFollower = 3;  ///< index of its plan
  enum class Place : std::uint8_t { kA = 1, kB = 4 };

  /// Creates the port to the line; none: the line itself.
  using MakePort = std::function<std::unique_ptr<port::Port>(EditedLine& line)>;
  explicit MovableGroup(const EditedLine::Edit& edit = {}, const EditedLine::Options& options = {},
                        const MakePort& make_port = {})
      : line(
            6,
            [edit](std::size_t drive, slaves::DeviceProfile& profile) {
              if (drive == 1 || drive == 4) set_alias(profile, kAlias);
              if (edit) edit(drive, profile);
            },
            options, wiring()),
        port_(make_port ? make_port(line) : nullptr),
        master(port_ ? *port_ : line.line(), line.clock) {
    for (const auto place : {Place::kA, Place::kB}) unplug(place);
  }

  void plug(Place place) {
    for (const auto drive : {head(place), head(place) + 1}) line.line().set_power(drive, true);
  }
  void unplug(Place place) {
    for (const auto drive : {head(place), head(place) + 1}) line.line().set_power(drive, false);
  }
  [[nodiscard]] static std::size_t head(Place place) { return static_cast<std::size_t>(place); }
  [[nodiscard]] bool in_op(Place place) {
    return line.slave(head(place)).state() == wire::AlState::kOp &&
           line.slave(head(place) + 1).state() == wire::AlState::kOp;
  }

  [[nodiscard]] static std::vector<ecat_master::SlavePlan> plans() {
    std::vector<ecat_master::SlavePlan> plans;
    for (std::size_t i = 0; i < 4; ++i) plans.push_back(LineOperation::plan(i, RunOptions{}));
    plans[kHead].hot_connect = plans[kFollower].hot_connect = true;
    plans[kHead].alias = kAlias;
    plans[kFollower].behind = ecat_master::HotConnectPlace{kHead, 1};
    return plans;
  }

  /// Takes the line to OP as it is now.
  [[nodiscard]] ecat_master::Result<void> start(std::vector<ecat_master::SlavePlan> plans = MovableGroup::plans()) {
    if (auto done = master.scan(); !done) return done;
    if (auto done = master.configure(std::move(plans)); !done) return done;
    const auto started = master.start_cycle(nullptr, {}, {}, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, line.clock);
    });
    if (!started) throw std::runtime_error(started.error().message());
    if (auto done = master.go_operational(); !done) return done;
    supervisor = std::make_unique<ecat_master::LineSupervisor>(master);
    return {};
  }
  void live(nanoseconds duration) {
    const auto end = line.clock.now() + duration;
    while (line.clock.now() < end) {
      master.pass(milliseconds{5});
      supervisor->poll();
    }
  }
  bool live_until_in_op(Place place) {
    const auto end = line.clock.now() + std::chrono::seconds{8};
    while (!in_op(place) && line.clock.now() < end) live(milliseconds{20});
    live(milliseconds{20});
    return in_op(place);
  }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor->history()) all += what_happened(event) + "\n";
    return all;
  }

  EditedLine line;

 private:
  std::unique_ptr<port::Port> port_;

 public:
  ecat_master::Master master;
  std::unique_ptr<ecat_master::LineSupervisor> supervisor;

 private:
  static slaves::Wiring wiring() {
    slaves::Wiring wiring(6);
    const nanoseconds cable{100};
    bool whole = wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0}, cable);
    whole = wiring.connect({0, 3}, {1, 0}, nanoseconds{250}) && whole;
    whole = wiring.connect({1, 1}, {2, 0}, cable) && whole;
    whole = wiring.connect({0, 1}, {3, 0}, cable) && whole;
    whole = wiring.connect({3, 1}, {4, 0}, nanoseconds{400}) && whole;
    whole = wiring.connect({4, 1}, {5, 0}, cable) && whole;
    if (!whole) throw std::logic_error("the test's own wiring");
    return wiring;
  }
};

}  // namespace driveline::bus_test
