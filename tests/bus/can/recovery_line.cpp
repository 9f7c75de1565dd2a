#include "recovery_line.hpp"

#include <algorithm>

#include "driveline/motion/axis/startup_sdos.hpp"

namespace driveline::bus_test {
namespace {

using canopen::NodePlan;
using canopen::PdoExchange;
using slaves::msd::MsdCanDrive;
using slaves::msd::Variant;
using namespace std::chrono_literals;

constexpr std::uint32_t kSerialNumber = 7100;       ///< serial number of the first drive; the others count from it
constexpr std::uint32_t kOtherSerialNumber = 9300;  ///< serial number of the other device

std::uint64_t raw_value(const slaves::ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t subindex) {
  return dictionary.raw(*dictionary.table().find(index, subindex));
}

class HarmedDrive final : public HarmedNode {
 public:
  HarmedDrive(const slaves::msd::MsdParameters& parameters, std::uint8_t id)
      : drive_(parameters, slaves::msd::CanConnection{slaves::msd::DipSwitch{id}, {}, 500us}) {}
  [[nodiscard]] slaves::cia301::Device& device() noexcept override { return drive_.device(); }
  [[nodiscard]] std::uint64_t value(std::uint16_t index, std::uint8_t subindex) const override {
    return raw_value(drive_.core().complete_values(), index, subindex);
  }
  [[nodiscard]] slaves::msd::DriveCore& core() noexcept { return drive_.core(); }

 private:
  MsdCanDrive drive_;
};

class HarmedDevice final : public HarmedNode {
 public:
  explicit HarmedDevice(std::uint8_t id) : dictionary_(slaves::cia301::sample_table()), device_(dictionary_, sample_) {
    sample_.node = sample_.next_node = id;
  }
  [[nodiscard]] slaves::cia301::Device& device() noexcept override { return device_; }
  [[nodiscard]] std::uint64_t value(std::uint16_t index, std::uint8_t subindex) const override {
    return raw_value(dictionary_, index, subindex);
  }

 private:
  slaves::ObjectDictionary dictionary_;
  slaves::cia301::SampleApplication sample_;
  slaves::cia301::Device device_;
};

/// What all nodes have.
NodePlan plan_of(std::uint8_t id, bool guarded) {
  NodePlan node;
  node.name = "node" + std::to_string(id);
  node.id = id;
  node.timeouts = {40ms, 150ms, 100ms};
  if (guarded) {
    node.error_control.guard_time = 20ms;
    node.error_control.life_time_factor = 3;
  } else {
    node.error_control.heartbeat = 20ms;
  }
  return node;
}

std::unique_ptr<HarmedDrive> make_drive(Variant variant, std::uint8_t id, std::uint32_t serial_number) {
  slaves::msd::MsdParameters parameters;
  parameters.variant = variant;
  parameters.serial_number = serial_number;
  return std::make_unique<HarmedDrive>(parameters, id);
}

}  // namespace

canopen::SendStatus AdapterPort::send(const canopen::Frame& frame) noexcept {
  bus_.advance(clock_.now());
  return controller_->send(frame) ? canopen::SendStatus::kSent : canopen::SendStatus::kBusy;
}

std::optional<canopen::ReceivedFrame> AdapterPort::receive() noexcept {
  bus_.advance(clock_.now());
  if (arrived_.empty()) return std::nullopt;
  const auto frame = arrived_.front();
  arrived_.pop_front();
  return frame;
}

bool AdapterPort::wait_readable(nanoseconds deadline) noexcept {
  for (;;) {
    bus_.advance(clock_.now());
    if (!arrived_.empty()) return true;
    if (clock_.now() >= deadline) return false;
    clock_.sleep_until(std::min(deadline, bus_.next_event()));
  }
}

canopen::PortStatistics AdapterPort::statistics() const noexcept {
  canopen::PortStatistics statistics;
  const bool off = controller_->errors().state() == slaves::can::ErrorState::kBusOff;
  statistics.state = off ? canopen::BusState::kBusOff : canopen::BusState::kErrorActive;
  return statistics;
}

void HarmedNode::set_power(bool on) {
  device().controller()->set_supply(on);
  if (on) device().power_on();
}

RecoveryLine::RecoveryLine(std::mt19937& random) : bus_({}, random()) {
  plan_.period = kPeriod;
  plan_.master_id = kMasterId;
  plan_.master_heartbeat = 20ms;
  const std::size_t drives = 2 + random() % 2;
  const std::size_t guarded = random() % drives;
  for (std::size_t i = 0; i < drives; ++i) {
    add_drive(random() % 3 == 0 ? Variant::kServoOne : Variant::kMsd, i == guarded);
  }
  add_device();
  other_ = make_drive(Variant::kMsd, kFirstNode, kOtherSerialNumber);
  bus_.attach(other_->device());
  other_->set_power(false);
  bus_.attach(stranger_);
}

void RecoveryLine::add_drive(Variant variant, bool guarded) {
  const auto id = static_cast<std::uint8_t>(kFirstNode + nodes_.size());
  auto drive = make_drive(variant, id, kSerialNumber + id);
  bus_.attach(drive->device());
  auto node = plan_of(id, guarded);
  node.serial_number = kSerialNumber + id;
  node.startup_sdos = {motion::startup_sdo(0x60C2, 1, std::uint8_t{4}), motion::startup_sdo(0x6084, 0, 71000U)};
  node.rpdos = {{.number = 1,
                 .transmission = 255,
                 .exchange = PdoExchange::kOnChange,
                 .objects = {{0x6040, 0, 16}, {0x6060, 0, 8}}},
                {.number = 2, .objects = {{0x60C1, 1, 32}}}};
  node.tpdos = {{.number = 1, .objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}}};
  // The ServoOne consumes no heartbeat, and no node with node guarding does.
  if (variant == Variant::kMsd && !guarded) node.error_control.master_tolerance = RecoveryLine::kMasterTolerance;
  plan_.nodes.push_back(node);
  drives_.push_back(&drive->core());
  nodes_.push_back(std::move(drive));
}

void RecoveryLine::add_device() {
  const auto id = static_cast<std::uint8_t>(kFirstNode + nodes_.size());
  auto device = std::make_unique<HarmedDevice>(id);
  bus_.attach(device->device());
  auto node = plan_of(id, false);
  node.error_control.master_tolerance = RecoveryLine::kMasterTolerance;
  node.startup_sdos = {motion::startup_sdo(0x2000, 0, std::int16_t{-321})};
  node.rpdos = {{.number = 1, .objects = {{0x2002, 0, 32}}}};
  node.tpdos = {{.number = 1, .objects = {{0x2000, 0, 16}, {0x2001, 0, 8}}}};
  plan_.nodes.push_back(node);
  drives_.push_back(nullptr);
  nodes_.push_back(std::move(device));
}

slaves::msd::DriveCore* RecoveryLine::drive(std::size_t number) noexcept {
  return drives_[number];
}

std::string RecoveryLine::sentences(const canopen::MasterResult<void>& result) const {
  std::string text;
  if (result) return text;
  for (const auto& error : result.error()) text += describe(error, plan_.nodes[error.node].name) + "\n";
  return text;
}

std::string RecoveryLine::sentence(const canopen::MasterEvent& event) const {
  const auto ms = std::chrono::duration_cast<milliseconds>(event.time).count();
  return std::to_string(ms) + " ms: " + describe(event, plan_.nodes[event.node].name);
}

std::string RecoveryLine::start() {
  canopen::CanMaster::Settings settings;
  settings.listen = 10ms;
  settings.retry_pause = 60ms;
  master_ = std::make_unique<canopen::CanMaster>(port_, clock_, plan_, settings);
  if (auto failure = sentences(master_->boot()); !failure.empty()) return failure;
  const auto started = master_->start_cycle(nullptr, {}, {}, [this](canopen::CanCycle& cycle) {
    return std::make_unique<motion::InlineRunner>(cycle, clock_);
  });
  if (!started) return "the cycle does not start";
  auto failure = sentences(master_->go_operational());
  collect();
  history_.clear();
  return failure;
}

void RecoveryLine::collect() {
  while (const auto event = master_->take_event()) history_.push_back(*event);
}

void RecoveryLine::live(nanoseconds duration) {
  master_->pass(duration);
  collect();
}

std::string RecoveryLine::shut_down() {
  return sentences(master_->shut_down());
}

bool RecoveryLine::fine(std::optional<std::size_t> except) noexcept {
  for (std::size_t i = 0; i < size(); ++i) {
    if (i == except) continue;
    if (master_->node(i).phase != canopen::NodePhase::kOperational) return false;
    if (node(i).device().state() != canopen::NmtState::kOperational) return false;
    if (!master_->cycle()->node_report(i).valid) return false;
  }
  return true;
}

std::string RecoveryLine::changed_object() {
  for (std::size_t i = 0; i < size(); ++i) {
    std::string wrong;
    const auto expect = [&](std::uint16_t index, std::uint8_t subindex, std::uint64_t wanted) {
      const auto found = node(i).value(index, subindex) & 0xFFFF'FFFFU;
      if (wrong.empty() && found != wanted) {
        wrong = plan(i).name + " is operational with " + std::to_string(found) + " in " + std::to_string(index) + ":" +
                std::to_string(subindex);
      }
    };
    const auto& control = plan(i).error_control;
    expect(0x1006, 0, static_cast<std::uint64_t>(kPeriod / 1us));
    expect(0x1017, 0, static_cast<std::uint64_t>(control.heartbeat.count()));
    expect(0x100C, 0, static_cast<std::uint64_t>(control.guard_time.count()));
    if (control.master_tolerance.count() > 0)
      expect(0x1016, 1, std::uint64_t{kMasterId} << 16U | static_cast<std::uint64_t>(kMasterTolerance.count()));
    expect(0x1A00, 1, plan(i).tpdos[0].objects[0].raw());
    expect(0x1A00, 2, plan(i).tpdos[0].objects[1].raw());
    expect(0x1800, 2, 1);
    if (drive(i) != nullptr) {
      expect(0x6084, 0, 71000);
    } else {
      expect(0x2000, 0, static_cast<std::uint32_t>(-321));
    }
    if (!wrong.empty()) return wrong;
  }
  return {};
}

}  // namespace driveline::bus_test
