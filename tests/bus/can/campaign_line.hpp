#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/canopen_sample.hpp"
#include "support/scripted_node.hpp"

/// A CAN line of a campaign: drives and other devices, a master of a few lines, somebody who disturbs them, and
/// somebody who only listens.
namespace driveline::bus_test {

using canopen::Frame;
using std::chrono::nanoseconds;

/// What disturbs a line.
enum class Disturbance : std::uint8_t {
  kLostFrames,
  kBitErrors,
  kNmt,
  kPower,
  kBusSupply,
  kBusOff,
  kDuplicate,
  kCutWire,
  kWiring,
  kBabble,
  kOtherBitRate,
  kDominant,
  kGarbage,
  kCount,
};
[[nodiscard]] const char* to_text(Disturbance disturbance) noexcept;

/// Listens, and remembers what it has heard of each node since forget(), and a sum over everything with its times.
class Listener final : public slaves::can::Node {
 public:
  /// What was heard of a node.
  struct Heard {
    unsigned states = 0;          ///< heartbeats and answers to guarding
    std::uint8_t last_state = 0;  ///< the last of them, without toggle bit
    unsigned boot_ups = 0;        ///< boot-up messages
    std::vector<Frame> emergencies{};
  };

  void connected(slaves::can::Controller& /*controller*/) override {}
  void receive(const Frame& frame, nanoseconds now) override;
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  void forget() { heard_ = {}; }
  [[nodiscard]] const Heard& of(std::uint8_t node) const { return heard_.at(node); }
  [[nodiscard]] std::uint64_t sum() const noexcept { return sum_; }

 private:
  void add(std::uint64_t value) noexcept;

  std::array<Heard, 128> heard_{};
  std::uint64_t sum_ = 0xCBF2'9CE4'8422'2325;
};

/// An SDO request and its answer; empty without one. `step` lets a millisecond pass.
[[nodiscard]] std::vector<std::byte> ask(slaves::can::Bus& bus, slaves::can::ScriptedNode& master, std::uint8_t node,
                                         std::span<const std::byte> request, const std::function<void()>& step);
/// Writes an entry; the abort code, 0 for none, ~0 without an answer.
[[nodiscard]] std::uint32_t write(slaves::can::Bus& bus, slaves::can::ScriptedNode& master, std::uint8_t node,
                                  std::uint16_t index, std::uint8_t subindex, std::uint32_t value, std::size_t size,
                                  const std::function<void()>& step);

/// A parameter file that a drive of this variant has stored: heartbeat, PDOs for profile velocity.
void store_parameters(slaves::msd::Variant variant, const std::string& file);

/// A drive of the line.
struct CampaignDrive {
  std::unique_ptr<slaves::msd::MsdCanDrive> drive;
  std::uint8_t node = 0;
  bool guarded = false;    ///< by remote frames, until a reset
  bool was_on = false;     ///< has had power
  double start_rad = 0.0;  ///< position before

  [[nodiscard]] bool bus_off() const;
  /// Value of an entry without the bus.
  [[nodiscard]] std::uint64_t value(std::uint16_t index, std::uint8_t subindex = 0) const;
};

/// A device of the line that is no drive.
struct CampaignDevice {
  explicit CampaignDevice(std::uint8_t id);
  std::uint8_t node;
  slaves::ObjectDictionary dictionary;
  slaves::cia301::SampleApplication application;
  slaves::cia301::Device device;

  [[nodiscard]] bool bus_off() const;
  [[nodiscard]] std::uint64_t value(std::uint16_t index, std::uint8_t subindex = 0) const;
};

class CampaignLine {
 public:
  /// `files`: parameter files by variant. `pieces`: in how many steps a millisecond is done.
  CampaignLine(unsigned seed, const std::array<std::string, 2>& files, int pieces);

  /// Time passes; the master sends SYNC, its heartbeat, remote frames, and setpoints while it commands. Returns what
  /// was wrong, empty: nothing.
  std::string live(std::chrono::milliseconds time);
  void command(bool on) noexcept { commanding_ = on; }
  void send(const Frame& frame) { master_.send_at(bus_.now(), frame); }
  /// Control word and target velocity of all drives, in turns per second.
  void send_setpoints(std::uint16_t word, double velocity);
  [[nodiscard]] std::uint32_t write(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint32_t value,
                                    std::size_t size);

  /// Starts a disturbance.
  void begin(Disturbance disturbance);
  /// Ends what goes on.
  void end();
  /// Sends frames that take the faults that wait; returns whether all were taken.
  bool use_up_faults();

  [[nodiscard]] std::size_t pick(std::size_t from, std::size_t to);
  [[nodiscard]] std::vector<CampaignDrive>& drives() noexcept { return drives_; }
  [[nodiscard]] std::vector<std::unique_ptr<CampaignDevice>>& devices() noexcept { return devices_; }
  [[nodiscard]] Listener& listener() noexcept { return listener_; }
  [[nodiscard]] slaves::can::ScriptedNode& master() noexcept { return master_; }

  static constexpr double kTopTurns = 2.0;  ///< largest target velocity

 private:
  void attach_all();
  void chores();
  [[nodiscard]] std::string motion_finding();
  [[nodiscard]] std::uint8_t any_node();
  void inject(const slaves::can::FrameFault& fault);
  void begin_lost_frames();
  void begin_bit_errors();
  void begin_nmt();
  void begin_power();
  void begin_bus_supply();
  void begin_bus_off();
  void begin_duplicate();
  void begin_cut();
  void begin_wiring();
  void begin_babble();
  void begin_other_bit_rate();
  void begin_dominant();
  void begin_garbage();
  void enter_stranger();
  [[nodiscard]] Frame garbage();

  std::mt19937 random_;
  int pieces_;
  slaves::can::Bus bus_;
  slaves::can::ScriptedNode master_;
  slaves::can::ScriptedNode stranger_;
  Listener listener_;
  std::vector<CampaignDrive> drives_;
  std::unique_ptr<slaves::msd::MsdCanDrive> twin_;  ///< with the node-ID of the first drive
  std::vector<std::unique_ptr<CampaignDevice>> devices_;
  std::size_t nodes_ = 0;
  std::vector<std::function<void()>> ends_;
  std::vector<slaves::can::FrameFault> faults_;
  bool commanding_ = false;
  std::uint64_t tick_ = 0;
};

}  // namespace driveline::bus_test
