#include "driveline/slaves/msd/faults.hpp"

#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr bool faults_in_order() noexcept {
  if (kFaults.size() != static_cast<std::size_t>(Fault::kCount)) return false;
  for (std::size_t i = 0; i < kFaults.size(); ++i) {
    if (static_cast<std::size_t>(kFaults[i].fault) != i) return false;
  }
  return true;
}
static_assert(faults_in_order(), "facts() finds a fault by its number");

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

wire::Emergency record_fault(ObjectDictionary& dictionary, const FaultFacts& fault,
                             std::uint32_t operating_hours) noexcept {
  const auto error_register = static_cast<std::uint8_t>(fault.error_register | kGenericError);
  dictionary.set(kErrorCode, fault.error_code);
  dictionary.set(kErrorRegister, error_register);
  dictionary.set(kErrorCount, 1U);
  dictionary.set(kLastError, fault.error_code | (unsigned{fault.number} << 16) | (unsigned{fault.location} << 24));
  wire::Emergency emergency;
  emergency.error_code = fault.error_code;
  emergency.error_register = error_register;
  emergency.data = {static_cast<std::byte>(fault.number), static_cast<std::byte>(fault.location),
                    static_cast<std::byte>(operating_hours), static_cast<std::byte>(operating_hours >> 8U),
                    static_cast<std::byte>(operating_hours >> 16U)};
  return emergency;
}

wire::Emergency record_acknowledgement(ObjectDictionary& dictionary) noexcept {
  dictionary.set(kErrorCode, 0U);
  dictionary.set(kErrorRegister, 0U);
  return {};
}

}  // namespace driveline::slaves::msd
