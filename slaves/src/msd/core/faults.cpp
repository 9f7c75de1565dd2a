#include "driveline/slaves/msd/core/faults.hpp"

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr bool faults_in_order() noexcept {
  if (kFaults.size() != static_cast<std::size_t>(Fault::kCount)) return false;
  for (std::size_t i = 0; i < kFaults.size(); ++i) {
    if (static_cast<std::size_t>(kFaults[i].fault) != i) return false;
  }
  return true;
}
static_assert(faults_in_order(), "facts() uses the fault as index");

constexpr std::uint8_t kGenericError = 0x01;

}  // namespace

std::string_view text(Warning warning) noexcept {
  switch (warning) {
    case Warning::kOverload:
      return "I2t near its limit";
    case Warning::kAmplifierTemperature:
      return "power stage nearly too hot";
    case Warning::kMotorTemperature:
      return "motor nearly too hot";
    case Warning::kDcLinkUndervoltage:
      return "DC link voltage low";
  }
  return {};
}

FaultRecord::FaultRecord(ObjectDictionary& dictionary) noexcept
    : dictionary_(&dictionary), text_slot_(dictionary.table().find(kMessagesIndex, 0)->slot) {}

FaultMessage FaultRecord::enter(Fault fault, std::uint32_t operating_hours) noexcept {
  const FaultFacts& f = facts(fault);
  const auto error_register = static_cast<std::uint8_t>(f.error_register | kGenericError);
  fault_ = fault;
  dictionary_->set(kValue.error_code, f.error_code);
  dictionary_->set(kValue.error_register, error_register);
  dictionary_->set(kValue.error_count, std::uint8_t{1});
  dictionary_->set(kValue.last_error, f.error_code | (unsigned{f.number} << 16) | (unsigned{f.location} << 24));
  dictionary_->text(text_slot_) = f.text;
  return {f.error_code, error_register, f.number, f.location, operating_hours};
}

FaultMessage FaultRecord::acknowledge() noexcept {
  fault_.reset();
  dictionary_->set(kValue.error_code, std::uint16_t{0});
  dictionary_->set(kValue.error_register, std::uint8_t{0});
  dictionary_->text(text_slot_).clear();
  return {};
}

}  // namespace driveline::slaves::msd
