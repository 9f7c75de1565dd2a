#include "driveline/slaves/canopen/eds_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "eds_model_builder.hpp"

namespace driveline::slaves::cia301 {
namespace {

/// Parses "6000:01", with or without the prefix 0x; empty: the text is not an address.
std::optional<Address> address_of(std::string_view text) {
  const auto hex = [](std::string_view digits, auto& value) {
    if (digits.starts_with("0x") || digits.starts_with("0X")) digits.remove_prefix(2);
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    return problem == std::errc{} && end == digits.data() + digits.size();
  };
  const auto colon = text.find(':');
  Address address;
  if (colon == std::string_view::npos) return std::nullopt;
  const bool good = hex(text.substr(0, colon), address.index) && hex(text.substr(colon + 1), address.subindex);
  return good ? std::optional(address) : std::nullopt;
}

}  // namespace

std::string describe(const EdsModelError& error) {
  using Fault = EdsModelError::Fault;
  switch (error.fault) {
    case Fault::kTooManyPdos:
      return fmt::format("it has the PDO {:04X}h, the simulation has {} PDOs of each direction", error.index,
                         EdsModel::kMostPdos);
    case Fault::kTooManyEntries:
      return fmt::format("it has {} objects and entries, the limit is {}", error.count, EdsModel::kMostEntries);
    case Fault::kNoNumber:
      return fmt::format("its {:04X}h:{:02X} is a text or a domain, a number is expected", error.index, error.subindex);
    case Fault::kImpossibleMapping:
      break;
  }
  return fmt::format(
      "the default mapping {:04X}h is not possible: up to 8 bytes of entries that the file has, each with its number "
      "of "
      "bits, are expected",
      error.index);
}

tl::expected<std::shared_ptr<const EdsModel>, EdsModelError> EdsModel::create(esi::EdsFile file) {
  const std::shared_ptr<EdsModel> model(new EdsModel);
  model->file_ = std::move(file);
  if (const auto built = EdsModelBuilder(*model).build(); !built) return tl::unexpected(built.error());
  return std::shared_ptr<const EdsModel>(model);
}

tl::expected<std::size_t, SignalNameError> EdsModel::find_entry(SignalId::Direction direction,
                                                                std::string_view name) const {
  using Fault = SignalNameError::Fault;
  const auto& all = entries(direction);
  const auto address = address_of(name);
  const auto refused = [&](Fault fault, const std::vector<std::size_t>& places) {
    SignalNameError error{.fault = fault, .direction = direction, .known = {}};
    for (const std::size_t place : places) {
      const auto& entry = all[place];
      error.known.push_back(fmt::format("\"{}\" ({:04X}:{:02X})", entry.name, entry.row->index, entry.row->subindex));
    }
    return tl::unexpected(std::move(error));
  };
  std::vector<std::size_t> matches;
  std::vector<std::size_t> everything;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& entry = all[i];
    const bool same = address ? *address == Address{entry.row->index, entry.row->subindex}
                              : entry.name == name || entry.short_name == name;
    if (same) matches.push_back(i);
    everything.push_back(i);
  }
  if (matches.empty()) return refused(Fault::kUnknown, everything);
  if (matches.size() > 1) return refused(Fault::kAmbiguous, matches);
  return matches.front();
}

}  // namespace driveline::slaves::cia301
