#include "driveline/slaves/canopen/eds_device.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include "driveline/slaves/bit_copy.hpp"

namespace driveline::slaves::cia301 {
namespace {

constexpr nanoseconds kStep = std::chrono::milliseconds{1};  ///< of drives and scripts

bool is_real_type(esi::DataType type) noexcept {
  return type == esi::DataType::kReal32 || type == esi::DataType::kReal64;
}

std::uint64_t raw_value(const EntryRow& row, double value) noexcept {
  return raw_from_number(row.type, is_real_type(row.type) ? value : std::nearbyint(value));
}

/// Whether a write to the row stores or restores parameters; the value that is read stays what the device can do.
bool is_store_command(const EntryRow& row) noexcept {
  return (row.index == 0x1010 || row.index == 0x1011) && row.subindex != 0;
}

}  // namespace

EdsDevice::EdsDevice(std::shared_ptr<const EdsModel> model, EdsDeviceOptions options)
    : model_(std::move(model)),
      options_(std::move(options)),
      dictionary_(model_->table()),
      drives_(model_->table()),
      periodic_(generic::count_drives(model_->table()) != 0 || !options_.inputs.empty()),
      device_(dictionary_, *this, model_->options()) {
  set_rows_.reserve(model_->entries(Direction::kInput).size());
}

SdoResult<void> EdsDevice::accept(const EntryRow& /*row*/, std::uint64_t /*raw*/) {
  return {};
}

void EdsDevice::written(const EntryRow& row) {
  if (is_store_command(row)) dictionary_.set_raw(row.slot, initial_raw(row));
  if (row.index >= 0x1600 && row.index < 0x1C00) build_loops();
  if ((row.access & access::kRxMappable) != 0) {
    drives_.exchange(dictionary_);
    loop_back();
  }
  changed_ = true;
}

/// Every reset, that of the communication, too, gives the serial number the value of the file.
std::uint8_t EdsDevice::node_id(Reset /*reset*/) {
  const EntryRow* serial = model_->table().find(0x1018, 4);
  const bool writable = serial != nullptr && !is_string(serial->type) && serial->slot != slot::kConstant;
  if (writable && options_.serial_number != 0) dictionary_.set_raw(serial->slot, options_.serial_number);
  return options_.node_id;
}

void EdsDevice::restart(Reset /*reset*/, nanoseconds now) {
  drives_.restart();
  build_loops();
  start_ = millisecond_ = now;
  changed_ = true;
}

/// The mapped entries of PDOs, in their order.
std::vector<const EntryRow*> EdsDevice::mapped(std::uint16_t first, std::size_t pdos) const {
  std::vector<const EntryRow*> entries;
  for (std::size_t n = 0; n < pdos; ++n) {
    const auto rows = model_->table().object(static_cast<std::uint16_t>(first + n));
    if (rows.empty() || rows.front().subindex != 0) continue;
    const std::uint64_t count = dictionary_.raw(rows.front());
    for (const EntryRow& row : rows.subspan(1)) {
      if (row.subindex > count) break;
      const std::uint64_t value = dictionary_.raw(row);
      const EntryRow* entry =
          model_->table().find(static_cast<std::uint16_t>(value >> 16U), static_cast<std::uint8_t>(value >> 8U));
      if (entry != nullptr && !is_string(entry->type)) entries.push_back(entry);
    }
  }
  return entries;
}

/// Whether a drive, a script or set_signal() determines the input.
bool EdsDevice::driven(const EntryRow& row) const noexcept {
  return drives_.owns(row.slot) ||
         std::any_of(options_.inputs.begin(), options_.inputs.end(),
                     [&row](const generic::ScriptedInput& script) { return script.input == &row; }) ||
         std::find(set_rows_.begin(), set_rows_.end(), &row) != set_rows_.end();
}

void EdsDevice::build_loops() {
  loops_.clear();
  if (!options_.loop_back) return;
  std::map<std::size_t, std::deque<const EntryRow*>> outputs;  // by length
  for (const EntryRow* row : mapped(0x1600, model_->options().rpdos)) {
    if (!drives_.owns(row->slot)) outputs[bit_size(*row)].push_back(row);
  }
  for (const EntryRow* row : mapped(0x1A00, model_->options().tpdos)) {
    auto& next = outputs[bit_size(*row)];
    const bool own_output = (row->access & access::kRxMappable) != 0;
    if (next.empty() || driven(*row) || own_output) continue;
    loops_.push_back({next.front(), row});
    next.pop_front();
  }
}

void EdsDevice::loop_back() noexcept {
  for (const Loop& loop : loops_) {
    const std::uint64_t value = dictionary_.raw(loop.output->slot);
    const std::size_t bits = bit_size(*loop.input);
    const std::uint64_t mask = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
    dictionary_.set_raw(loop.input->slot,
                        is_signed(loop.input->type) ? sign_extended(value & mask, bits) : value & mask);
  }
}

void EdsDevice::follow_scripts(nanoseconds now) noexcept {
  for (const auto& script : options_.inputs) {
    dictionary_.set_raw(script.input->slot, raw_value(*script.input, script.signal.at(now - start_)));
  }
}

void EdsDevice::advance(nanoseconds now) {
  if (periodic_ && millisecond_ <= now) {
    millisecond_ = (now / kStep + 1) * kStep;
    drives_.advance(dictionary_, now);
    follow_scripts(now);
    changed_ = true;
  }
  if (std::exchange(changed_, false)) device_.watch(now);
}

nanoseconds EdsDevice::next_wake() const noexcept {
  if (changed_) return nanoseconds{0};
  return periodic_ ? millisecond_ : can::kNever;
}

void EdsDevice::rpdo_applied(std::size_t /*number*/, nanoseconds now) {
  drives_.exchange(dictionary_);
  loop_back();
  device_.watch(now);
}

tl::expected<SignalId, SignalNameError> EdsDevice::find_signal(Direction direction, std::string_view name) const {
  return model_->find_entry(direction, name).map([direction](std::size_t place) { return SignalId{direction, place}; });
}

tl::expected<void, SignalValueError> EdsDevice::check_signal_value(std::size_t input, double value) const {
  return generic::check_signal(*model_->entries(Direction::kInput)[input].row, {.low = value});
}

void EdsDevice::set_signal(std::size_t input, double value) noexcept {
  const EntryRow& row = *model_->entries(Direction::kInput)[input].row;
  std::erase_if(options_.inputs, [&row](const generic::ScriptedInput& script) { return script.input == &row; });
  std::erase_if(loops_, [&row](const Loop& loop) { return loop.input == &row; });
  if (std::find(set_rows_.begin(), set_rows_.end(), &row) == set_rows_.end()) set_rows_.push_back(&row);
  dictionary_.set_raw(row.slot, raw_value(row, value));
  changed_ = true;
}

double EdsDevice::signal(SignalId id) const noexcept {
  const EntryRow& row = *model_->entries(id.direction)[id.number].row;
  return number_from_raw(row.type, dictionary_.raw(row.slot));
}

}  // namespace driveline::slaves::cia301
