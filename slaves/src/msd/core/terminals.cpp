#include "driveline/slaves/msd/core/terminals.hpp"

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

/// Terminals in the order of the selectors P 100-P 110. No manual assigns terminals to P 111 and P 112, and 2079h has
/// no further ones: these parameters are stored without effect.
constexpr std::array kInputTerminals = {Input::kEnpo,  Input::kIsd00, Input::kIsd01, Input::kIsd02,
                                        Input::kIsd03, Input::kIsd04, Input::kIsd05, Input::kIsd06,
                                        Input::kIsdsh, Input::kIsa00, Input::kIsa01};
/// Terminals in the order of the selectors P 122-P 126.
constexpr std::array kOutputTerminals = {Output::kOsd00, Output::kOsd01, Output::kOsd02, Output::kBrake,
                                         Output::kRelay};

/// 60FEh has the bits of 208Fh 16 positions higher (MSD manual Tables 10.7, 10.9).
constexpr unsigned kBusShift = 16;
constexpr std::uint32_t kSafeStopBit = 1U << 18U;
constexpr std::uint32_t kEnpoBit = 1U << 19U;
constexpr std::uint16_t kIsd05Selector = 0x2000 + 106;
constexpr std::uint16_t kIsd06Selector = 0x2000 + 107;
constexpr std::uint16_t kBrakeSelector = 0x2000 + 125;

}  // namespace

bool valid_input_function(std::uint16_t index, std::uint64_t function) noexcept {
  if (function > UINT16_MAX) return false;
  switch (static_cast<InputFunction>(function)) {
    case InputFunction::kOff:
    case InputFunction::kFaultReset:
    case InputFunction::kPositiveLimit:
    case InputFunction::kNegativeLimit:
    case InputFunction::kHomeSwitch:
      return true;
    case InputFunction::kProbe:
      return index == kIsd05Selector || index == kIsd06Selector;
  }
  return false;
}

bool valid_inversion(std::uint64_t inputs) noexcept {
  constexpr std::uint64_t kInvertible = 0x1007E;  // ISD00 to ISD06
  return (inputs & ~kInvertible) == 0;
}

bool valid_output_function(std::uint16_t index, std::uint64_t function) noexcept {
  if (function > UINT16_MAX) return false;
  switch (static_cast<OutputFunction>(function)) {
    case OutputFunction::kOff:
    case OutputFunction::kLimit:
    case OutputFunction::kBusEachMs:
    case OutputFunction::kBusEachStep:
      return true;
    case OutputFunction::kBrake:
      return index == kBrakeSelector;
  }
  return false;
}

void Terminals::set(Input input, bool level) noexcept {
  const std::uint32_t bit = 1U << static_cast<unsigned>(input);
  if (((inputs_ & bit) != 0) == level) return;
  inputs_ ^= bit;
  evaluate();
}

void Terminals::configure(const ObjectDictionary& dictionary) noexcept {
  for (std::size_t i = 0; i < input_functions_.size(); ++i) {
    input_functions_[i] = static_cast<InputFunction>(dictionary.get(kValue.input_functions[i]));
  }
  for (std::size_t i = 0; i < output_functions_.size(); ++i) {
    output_functions_[i] = static_cast<OutputFunction>(dictionary.get(kValue.output_functions[i]));
  }
  inverted_ = dictionary.get(kValue.input_inversion);
  sort_outputs();
  evaluate();
}

void Terminals::evaluate() noexcept {
  signals_ = {};
  for (std::size_t i = 0; i < kInputTerminals.size(); ++i) {
    if (((inputs_ ^ inverted_) >> static_cast<unsigned>(kInputTerminals[i]) & 1U) == 0) continue;
    switch (input_functions_[i]) {
      case InputFunction::kOff:
        break;
      case InputFunction::kFaultReset:
        signals_.fault_reset = true;
        break;
      case InputFunction::kPositiveLimit:
        signals_.positive_limit = true;
        break;
      case InputFunction::kNegativeLimit:
        signals_.negative_limit = true;
        break;
      case InputFunction::kHomeSwitch:
        signals_.home_switch = true;
        break;
      case InputFunction::kProbe:
        signals_.probe[kInputTerminals[i] == Input::kIsd05 ? 0 : 1] = true;
        break;
    }
  }
}

void Terminals::sort_outputs() noexcept {
  bus_each_step_ = bus_each_ms_ = limit_ = brake_ = driven_ = 0;
  for (std::size_t i = 0; i < kOutputTerminals.size(); ++i) {
    const std::uint32_t bit = 1U << static_cast<unsigned>(kOutputTerminals[i]);
    switch (output_functions_[i]) {
      case OutputFunction::kOff:
        break;
      case OutputFunction::kLimit:
        limit_ |= bit;
        break;
      case OutputFunction::kBrake:
        brake_ |= bit;
        break;
      case OutputFunction::kBusEachStep:
        bus_each_step_ |= bit;
        continue;
      case OutputFunction::kBusEachMs:
        bus_each_ms_ |= bit;
        continue;
    }
    driven_ |= bit;
  }
}

void Terminals::step_outputs(const OutputConditions& conditions) noexcept {
  const std::uint32_t due = bus_each_step_ | (conditions.millisecond ? bus_each_ms_ : 0U);
  const std::uint32_t from_bus = due & conditions.mask >> kBusShift;
  const std::uint32_t own = (conditions.limit ? limit_ : 0U) | (conditions.brake_open ? brake_ : 0U);
  constexpr std::uint32_t kStoRelay = 1U << static_cast<unsigned>(Output::kStoRelay);
  const std::uint32_t sto_relay = level(Input::kIsdsh) ? 0U : kStoRelay;  // safe torque off is active
  const std::uint32_t held = outputs_ & ~(driven_ | from_bus | kStoRelay);
  outputs_ = held | own | (from_bus & conditions.physical_outputs >> kBusShift) | sto_relay;
}

std::uint32_t Terminals::function_image() const noexcept {
  return (signals_.negative_limit ? 1U : 0U) | (signals_.positive_limit ? 2U : 0U) | (signals_.home_switch ? 4U : 0U) |
         (level(Input::kIsdsh) ? 0U : kSafeStopBit) | (level(Input::kEnpo) ? kEnpoBit : 0U);
}

}  // namespace driveline::slaves::msd
