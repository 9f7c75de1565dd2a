#include "campaign_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"

namespace driveline::bus_test {
namespace {

using canopen::FrameKind;
using canopen::NmtCommand;
using slaves::can::FrameFault;
using slaves::can::FrameFaultKind;
using slaves::msd::CanConnection;
using slaves::msd::DipSwitch;
using slaves::msd::MsdCanDrive;
using slaves::msd::MsdParameters;
using slaves::msd::Variant;
using namespace std::chrono_literals;

constexpr std::uint8_t kMaster = 127;
constexpr std::uint8_t kFirstDevice = 20;
constexpr double kIncrementsPerTurn = 1 << 20;
constexpr std::uint32_t kMapped = 0x7FF;  ///< mask of a whole identifier

constexpr std::array kNames{"lost frames",      "bit errors",        "NMT",      "power", "24 V at X32",
                            "bus off",          "duplicate node-ID", "cut wire", "cable", "babbling",
                            "another bit rate", "stuck dominant",    "garbage"};
static_assert(kNames.size() == static_cast<std::size_t>(Disturbance::kCount));

std::uint64_t value_of(const slaves::ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t subindex) {
  return dictionary.raw(*dictionary.table().find(index, subindex));
}

Frame setpoint(std::uint8_t node, std::uint16_t word, double turns_per_s) {
  const auto velocity = static_cast<std::int32_t>(std::lrint(turns_per_s * kIncrementsPerTurn));
  std::array<std::byte, 6> data{};
  bytes::store_le(data, word);
  bytes::store_le(std::span(data).subspan(2), static_cast<std::uint32_t>(velocity));
  return Frame::of(0x200U + node, data);
}

}  // namespace

const char* to_text(Disturbance disturbance) noexcept {
  return kNames[static_cast<std::size_t>(disturbance)];
}

/// FNV-1a over 64 bits.
void Listener::add(std::uint64_t value) noexcept {
  for (unsigned shift = 0; shift < 64; shift += 8) sum_ = (sum_ ^ (value >> shift & 0xFFU)) * 0x100'0000'01B3;
}

void Listener::receive(const Frame& frame, nanoseconds now) {
  add(static_cast<std::uint64_t>(now.count()));
  add(frame.identifier.value | (frame.identifier.extended ? 1ULL << 32U : 0) |
      static_cast<std::uint64_t>(frame.kind) << 40U | static_cast<std::uint64_t>(frame.length) << 48U);
  for (const std::byte byte : frame.payload()) add(std::to_integer<std::uint64_t>(byte));
  if (frame.kind != FrameKind::kData || frame.identifier.extended) return;
  Heard& heard = heard_[frame.identifier.value & 0x7FU];
  const std::uint32_t function = frame.identifier.value & ~0x7FU;
  if (function == 0x080 && frame.identifier.value != function) heard.emergencies.push_back(frame);
  if (function != 0x700 || frame.length != 1) return;
  heard.last_state = std::to_integer<std::uint8_t>(frame.data[0] & std::byte{0x7F});
  ++(frame.data[0] == std::byte{0} ? heard.boot_ups : heard.states);
}

std::vector<std::byte> ask(slaves::can::Bus& bus, slaves::can::ScriptedNode& master, std::uint8_t node,
                           std::span<const std::byte> request, const std::function<void()>& step) {
  constexpr int kPatience = 10;
  master.received.clear();
  master.send_at(bus.now(), Frame::of(0x600U + node, request));
  for (int i = 0; i < kPatience; ++i) {
    step();
    for (const auto& seen : master.received) {
      if (seen.frame.identifier.value == 0x580U + node) return bytes_test::copy_of(seen.frame.payload());
    }
  }
  return {};
}

std::uint32_t write(slaves::can::Bus& bus, slaves::can::ScriptedNode& master, std::uint8_t node, std::uint16_t index,
                    std::uint8_t subindex, std::uint32_t value, std::size_t size, const std::function<void()>& step) {
  const auto command = canopen::expedited_command(canopen::SdoRequest::kInitiateDownload, size);
  const canopen::SdoMessage request{command, index, subindex, bytes::to_le_bytes(value)};
  const auto answer = ask(bus, master, node, request.encode(), step);
  if (answer.empty()) return ~0U;
  return answer[0] == std::byte{0x80} ? bytes::load_le<std::uint32_t>(std::span(answer).subspan(4)) : 0;
}

void store_parameters(Variant variant, const std::string& file) {
  constexpr std::uint8_t kNode = 3;
  constexpr auto kRamp = static_cast<std::uint32_t>(100 * kIncrementsPerTurn);
  slaves::can::Bus bus;
  slaves::can::ScriptedNode master;
  MsdParameters parameters;
  parameters.variant = variant;
  parameters.parameter_file = file;
  MsdCanDrive drive(parameters, {DipSwitch{kNode}, {}, 500us});
  bus.attach(master);
  bus.attach(drive.device());
  const auto step = [&] { bus.advance(bus.now() + 1ms); };
  for (int i = 0; i < 5; ++i) step();
  struct Row {
    std::uint16_t index;
    std::uint8_t subindex;
    std::uint32_t value;
    std::size_t size;
  };
  for (const auto& [index, subindex, value, size] :
       {Row{0x1017, 0, 20, 2}, Row{0x6083, 0, kRamp, 4}, Row{0x6084, 0, kRamp, 4}, Row{0x6085, 0, kRamp, 4},
        Row{0x1400, 1, 0x8000'0200U + kNode, 4}, Row{0x1600, 1, 0x6040'0010, 4}, Row{0x1600, 2, 0x60FF'0020, 4},
        Row{0x1600, 0, 2, 1}, Row{0x1400, 1, 0x200U + kNode, 4}, Row{0x1800, 1, 0x8000'0180U + kNode, 4},
        Row{0x1800, 2, 1, 1}, Row{0x1A00, 1, 0x6041'0010, 4}, Row{0x1A00, 2, 0x6064'0020, 4}, Row{0x1A00, 0, 2, 1},
        Row{0x1800, 1, 0x180U + kNode, 4}, Row{0x1010, 1, 0x6576'6173, 4}}) {
    if (write(bus, master, kNode, index, subindex, value, size, step) == 0) continue;
    throw std::runtime_error("a parameter is refused: " + std::to_string(index));
  }
}

bool CampaignDrive::bus_off() const {
  return drive->device().controller()->errors().state() == slaves::can::ErrorState::kBusOff;
}

std::uint64_t CampaignDrive::value(std::uint16_t index, std::uint8_t subindex) const {
  return value_of(drive->core().complete_values(), index, subindex);
}

CampaignDevice::CampaignDevice(std::uint8_t id)
    : node(id), dictionary(slaves::cia301::sample_table()), device(dictionary, application) {
  application.node = application.next_node = id;
}

bool CampaignDevice::bus_off() const {
  return device.controller()->errors().state() == slaves::can::ErrorState::kBusOff;
}

std::uint64_t CampaignDevice::value(std::uint16_t index, std::uint8_t subindex) const {
  return value_of(dictionary, index, subindex);
}

CampaignLine::CampaignLine(unsigned seed, const std::array<std::string, 2>& files, int pieces)
    : random_(seed), pieces_(pieces), bus_({}, seed) {
  const auto make = [&](std::size_t variant, std::uint8_t node, double position_rad) {
    MsdParameters parameters;
    parameters.variant = variant == 0 ? Variant::kMsd : Variant::kServoOne;
    parameters.parameter_file = files.at(variant);
    parameters.initial_position_rad = position_rad;
    return std::make_unique<MsdCanDrive>(parameters, CanConnection{DipSwitch{node}, {}, 500us});
  };
  const std::size_t count = pick(2, 3);
  for (std::size_t i = 0; i < count; ++i) {
    CampaignDrive drive;
    drive.node = static_cast<std::uint8_t>(i + 1);
    drive.start_rad = 0.25 * static_cast<double>(i);
    drive.drive = make(pick(0, 1), drive.node, drive.start_rad);
    drives_.push_back(std::move(drive));
  }
  twin_ = make(0, drives_.front().node, 1.0);
  twin_->set_bus_supply(false);
  const std::size_t others = pick(1, 2);
  for (std::size_t i = 0; i < others; ++i) {
    devices_.push_back(std::make_unique<CampaignDevice>(static_cast<std::uint8_t>(kFirstDevice + i)));
  }
  attach_all();
}

/// In any order; who listens is the last one.
void CampaignLine::attach_all() {
  std::vector<std::function<void()>> nodes;
  nodes.emplace_back([this] { bus_.attach(master_, {.automatic_recovery = true}); });
  nodes.emplace_back([this] { bus_.attach(stranger_, {.automatic_recovery = true}); });
  nodes.emplace_back([this] { bus_.attach(twin_->device()); });
  for (auto& one : drives_) nodes.emplace_back([this, &one] { bus_.attach(one.drive->device()); });
  for (auto& one : devices_) nodes.emplace_back([this, &one] { bus_.attach(one->device); });
  std::shuffle(nodes.begin(), nodes.end(), random_);
  for (const auto& attach : nodes) attach();
  nodes_ = nodes.size() + 1;
  bus_.attach(listener_, {.listen_only = true, .error_frames = true});
  stranger_.controller().set_power(false);
}

std::size_t CampaignLine::pick(std::size_t from, std::size_t to) {
  return std::uniform_int_distribution<std::size_t>(from, to)(random_);
}

std::uint32_t CampaignLine::write(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint32_t value,
                                  std::size_t size) {
  return bus_test::write(bus_, master_, node, index, subindex, value, size, [this] { static_cast<void>(live(1ms)); });
}

void CampaignLine::send_setpoints(std::uint16_t word, double velocity) {
  for (const auto& one : drives_) send(setpoint(one.node, word, velocity));
}

void CampaignLine::chores() {
  ++tick_;
  if (tick_ % 4 == 0) send(Frame::of(0x080, {}));
  if (tick_ % 20 == 0) send(Frame::of(0x700U + kMaster, std::array{std::byte{5}}));
  for (const auto& one : drives_) {
    if (one.guarded && tick_ % 15 == 0) send(Frame::remote({0x700U + one.node, false}, 1));
    if (!commanding_ || tick_ % 8 != 0) continue;
    const double velocity = std::uniform_real_distribution(-kTopTurns, kTopTurns)(random_);
    send(setpoint(one.node, 0x0F, velocity));
  }
}

std::string CampaignLine::live(std::chrono::milliseconds time) {
  std::string finding;
  for (auto left = time; left > 0ms; left -= 1ms) {
    chores();
    const nanoseconds begin = bus_.now();
    for (int piece = 1; piece <= pieces_; ++piece) bus_.advance(begin + nanoseconds{1ms} * piece / pieces_);
    if (finding.empty()) finding = motion_finding();
  }
  return finding;
}

/// No drive turns faster than it was ever told to, and none that was never on turns at all.
std::string CampaignLine::motion_finding() {
  constexpr double kLimit = 1.3 * kTopTurns * 2.0 * std::numbers::pi;
  for (auto& one : drives_) {
    const auto& core = one.drive->core();
    one.was_on = one.was_on || core.power_on();
    const std::string name = "drive " + std::to_string(one.node);
    if (!(std::abs(core.velocity_rad_s()) <= kLimit)) {
      return name + " turns with " + std::to_string(core.velocity_rad_s()) + " rad/s";
    }
    if (!one.was_on && !(std::abs(core.position_rad() - one.start_rad) < 1e-6)) return name + " moves without power";
  }
  return {};
}

std::uint8_t CampaignLine::any_node() {
  const std::size_t which = pick(0, drives_.size() + devices_.size() - 1);
  return which < drives_.size() ? drives_[which].node : devices_[which - drives_.size()]->node;
}

void CampaignLine::inject(const FrameFault& fault) {
  bus_.inject(fault);
  faults_.push_back(fault);
}

void CampaignLine::begin(Disturbance disturbance) {
  switch (disturbance) {
    case Disturbance::kLostFrames:
      return begin_lost_frames();
    case Disturbance::kBitErrors:
      return begin_bit_errors();
    case Disturbance::kNmt:
      return begin_nmt();
    case Disturbance::kPower:
      return begin_power();
    case Disturbance::kBusSupply:
      return begin_bus_supply();
    case Disturbance::kBusOff:
      return begin_bus_off();
    case Disturbance::kDuplicate:
      return begin_duplicate();
    case Disturbance::kCutWire:
      return begin_cut();
    case Disturbance::kWiring:
      return begin_wiring();
    case Disturbance::kBabble:
      return begin_babble();
    case Disturbance::kOtherBitRate:
      return begin_other_bit_rate();
    case Disturbance::kDominant:
      return begin_dominant();
    case Disturbance::kGarbage:
      return begin_garbage();
    case Disturbance::kCount:
      return;
  }
}

void CampaignLine::end() {
  for (const auto& one : std::exchange(ends_, {})) one();
}

void CampaignLine::begin_lost_frames() {
  const std::uint8_t node = any_node();
  const std::array<std::uint32_t, 6> identifiers{0x000,         0x080,         0x180U + node,
                                                 0x200U + node, 0x700U + node, 0x700U + kMaster};
  FrameFault fault{.kind = FrameFaultKind::kLost};
  fault.identifier = identifiers[pick(0, identifiers.size() - 1)];
  fault.mask = pick(0, 3) == 0 ? 0 : kMapped;
  fault.count = static_cast<std::uint32_t>(pick(1, 20));
  if (pick(0, 1) == 0) fault.receiver = pick(0, nodes_ - 2);
  inject(fault);
}

void CampaignLine::begin_bit_errors() {
  const std::uint8_t node = any_node();
  const std::array<std::uint32_t, 4> identifiers{0x080, 0x180U + node, 0x200U + node, 0x700U + node};
  FrameFault fault{.kind = FrameFaultKind::kBitError};
  fault.identifier = identifiers[pick(0, identifiers.size() - 1)];
  fault.mask = pick(0, 2) == 0 ? 0 : kMapped;
  fault.count = static_cast<std::uint32_t>(pick(1, 12));
  fault.bit = pick(0, 100);
  inject(fault);
}

/// Frames of one node that others destroy until it is bus off.
void CampaignLine::begin_bus_off() {
  FrameFault fault{.kind = FrameFaultKind::kBitError};
  fault.identifier = (pick(0, 1) == 0 ? 0x180U : 0x700U) + any_node();
  fault.mask = kMapped;
  fault.count = static_cast<std::uint32_t>(pick(32, 40));
  inject(fault);
}

void CampaignLine::begin_nmt() {
  constexpr std::array kCommands{NmtCommand::kStart, NmtCommand::kStop, NmtCommand::kEnterPreOperational,
                                 NmtCommand::kResetNode, NmtCommand::kResetCommunication};
  const auto command = kCommands[pick(0, kCommands.size() - 1)];
  const std::uint8_t node = pick(0, 4) == 0 ? std::uint8_t{0} : any_node();
  send(canopen::NmtRequest{command, node}.frame());
}

void CampaignLine::begin_power() {
  const std::size_t which = pick(0, drives_.size() + devices_.size() - 1);
  if (which < drives_.size()) return drives_[which].drive->restart();
  devices_[which - drives_.size()]->device.power_on();
}

void CampaignLine::begin_bus_supply() {
  MsdCanDrive& drive = *drives_[pick(0, drives_.size() - 1)].drive;
  drive.set_bus_supply(false);
  ends_.emplace_back([&drive] { drive.set_bus_supply(true); });
}

void CampaignLine::begin_duplicate() {
  twin_->set_bus_supply(true);
  ends_.emplace_back([this] { twin_->set_bus_supply(false); });
}

void CampaignLine::begin_cut() {
  const std::size_t place = pick(0, nodes_ - 2);
  bus_.cut(place);
  ends_.emplace_back([this, place] { bus_.mend(place); });
}

void CampaignLine::begin_wiring() {
  slaves::can::Wiring wiring;
  switch (pick(0, 2)) {
    case 0:
      wiring.first_terminated = false;
      break;
    case 1:
      wiring.first_terminated = wiring.last_terminated = false;
      break;
    default:
      wiring.length_m = 100.0;  // too long for 1 Mbit/s
  }
  bus_.set_wiring(wiring);
  ends_.emplace_back([this] { bus_.set_wiring({}); });
}

void CampaignLine::enter_stranger() {
  stranger_.controller().set_power(true);
  ends_.emplace_back([this] {
    auto& controller = stranger_.controller();
    controller.set_power(false);
    controller.babble({});
    controller.hold_dominant(false);
    controller.set_bit_rate(1'000'000);
  });
}

void CampaignLine::begin_babble() {
  const std::array frames{Frame::of(0x080, {}), Frame::of(0x001, bytes_test::hex("00 00 00 00 00 00 00 00")),
                          Frame::of(0x7FE, {}), Frame::of(0x000, bytes_test::hex("01 00")),
                          Frame::remote({0x181, false}, 6)};
  enter_stranger();
  stranger_.controller().babble(frames[pick(0, frames.size() - 1)]);
}

void CampaignLine::begin_other_bit_rate() {
  constexpr std::array<std::uint32_t, 3> kRates{500'000, 250'000, 125'000};
  const std::uint32_t rate = kRates[pick(0, kRates.size() - 1)];
  if (pick(0, 1) == 0) {
    auto& controller = *drives_[pick(0, drives_.size() - 1)].drive->device().controller();
    controller.set_bit_rate(rate);
    ends_.emplace_back([&controller] { controller.set_bit_rate(1'000'000); });
    return;
  }
  enter_stranger();
  stranger_.controller().set_bit_rate(rate);
  for (int i = 0; i < 3; ++i) stranger_.send_at(bus_.now(), garbage());
}

void CampaignLine::begin_dominant() {
  enter_stranger();
  stranger_.controller().hold_dominant(true);
}

void CampaignLine::begin_garbage() {
  enter_stranger();
  const std::size_t count = pick(10, 60);
  for (std::size_t i = 0; i < count; ++i)
    stranger_.send_at(bus_.now() + std::chrono::microseconds{static_cast<std::int64_t>(pick(0, 2000))}, garbage());
}

/// Any frame that commands no motion and changes no object.
Frame CampaignLine::garbage() {
  std::array<std::byte, 8> data{};
  for (auto& byte : data) byte = static_cast<std::byte>(pick(0, 255));
  const auto length = static_cast<std::uint8_t>(pick(0, 8));
  if (pick(0, 7) == 0)
    return Frame::of({static_cast<std::uint32_t>(pick(0, 0x1FFF'FFFF)), true}, std::span(data).first(length));
  auto identifier = static_cast<std::uint32_t>(pick(0, 0x7FF));
  if (pick(0, 2) == 0)
    identifier = static_cast<std::uint32_t>(std::array<std::size_t, 3>{0x000, 0x080, 0x77F}[pick(0, 2)]);
  const bool of_a_device = (identifier >= 0x200 && identifier < 0x580) || (identifier >= 0x600 && identifier < 0x680);
  if (of_a_device) identifier = 0x700 + (identifier & 0x7FU);
  if (pick(0, 5) == 0) return Frame::remote({identifier, false}, length);
  if (identifier == 0x000) return canopen::NmtRequest{static_cast<NmtCommand>(data[0]), any_node()}.frame();
  return Frame::of(identifier, std::span(data).first(length));
}

/// Extended frames, which mean nothing to anybody, but whose last 11 bits are those that a fault waits for.
bool CampaignLine::use_up_faults() {
  constexpr int kPatience = 400;
  stranger_.controller().set_power(true);
  int left = kPatience;
  for (const FrameFault& fault : std::exchange(faults_, {})) {
    const Frame frame = Frame::of({0x1000'0000U | fault.identifier, true}, {});
    const std::size_t wanted = fault.kind == FrameFaultKind::kLost ? fault.count : 1;
    stranger_.sent.clear();
    // Beside what it has still to send from before.
    const auto passed = [&] {
      return static_cast<std::size_t>(std::count_if(stranger_.sent.begin(), stranger_.sent.end(),
                                                    [&](const auto& seen) { return seen.frame == frame; }));
    };
    while (passed() < wanted && left-- > 0) {
      // What waited is lost when the stranger becomes bus off.
      if (stranger_.controller().queue().size() == 0) stranger_.send_at(bus_.now(), frame);
      static_cast<void>(live(1ms));
    }
  }
  stranger_.controller().set_power(false);
  return left > 0;
}

}  // namespace driveline::bus_test
