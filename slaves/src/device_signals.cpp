#include "driveline/slaves/device_signals.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

namespace driveline::slaves {
namespace {

constexpr std::size_t kMaxListed = 30;  ///< names that a sentence lists

std::string listed(const std::vector<std::string>& names) {
  const std::span shown{names.data(), std::min(names.size(), kMaxListed)};
  const auto text = fmt::format("there are {}", fmt::join(shown, ", "));
  return names.size() > kMaxListed ? fmt::format("{} and {} more", text, names.size() - kMaxListed) : text;
}

struct ValueSentence {
  std::string operator()(const SignalIsNoNumber& /*error*/) const { return "the entry is not a number"; }
  std::string operator()(const SignalBeyondEntry& error) const {
    return fmt::format("{} does not fit the {} bits of the entry, {} to {} do", error.value, error.bits, error.lowest,
                       error.highest);
  }
  std::string operator()(const SignalIsNoLevel& error) const {
    return fmt::format("{} does not fit {}, 0 or 1 is expected", error.value, error.name);
  }
  std::string operator()(const SignalBeyondInput& error) const {
    return fmt::format("{} does not fit {}, {} to {} {} is expected", error.value, error.name, error.lowest,
                       error.highest, error.unit);
  }
};

}  // namespace

std::string describe(const SignalNameError& error) {
  if (error.fault == SignalNameError::Fault::kAmbiguous) {
    return fmt::format("is not a unique name; {}", listed(error.known));
  }
  const auto* const direction = error.direction == SignalId::Direction::kInput ? "input" : "output";
  return fmt::format(
      "is no {} of the {}; {}", direction, error.owner,
      error.known.empty() ? fmt::format("the {} has no {}s", error.owner, direction) : listed(error.known));
}

std::string describe(const SignalValueError& error) {
  return std::visit(ValueSentence{}, error);
}

}  // namespace driveline::slaves
