#include "text/signal_text.hpp"

#include <fmt/format.h>

#include <optional>

#include "driveline/runtime/config/finite_number.hpp"

namespace driveline::cli {
namespace {

using Direction = slaves::SignalId::Direction;

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

tl::expected<SignalSetting, std::string> parse_one(std::string_view name, std::string_view text,
                                                   const slaves::DeviceSignals& signals) {
  const auto place = signals.find_signal(Direction::kInput, name);
  if (!place) return tl::unexpected(fmt::format("\"{}\" {}", name, describe(place.error())));
  const auto value = runtime::finite_number(text);
  if (!value) return tl::unexpected(fmt::format("{} is \"{}\", a number is expected", name, text));
  if (const auto fits = signals.check_signal_value(place->number, *value); !fits) {
    return tl::unexpected(fmt::format("{}: {}", name, describe(fits.error())));
  }
  return SignalSetting{place->number, *value};
}

}  // namespace

tl::expected<std::vector<SignalSetting>, std::string> parse_signal_settings(std::string_view text,
                                                                            const slaves::DeviceSignals& signals) {
  std::vector<SignalSetting> settings;
  for (auto rest = trimmed(text); !rest.empty(); rest = trimmed(rest)) {
    const auto equals = rest.find('=');
    if (equals == std::string_view::npos) {
      return tl::unexpected(fmt::format("\"{}\" is not a setting, INPUT=VALUE is expected", rest));
    }
    const auto end = std::min(rest.find(' ', equals), rest.size());
    const auto setting = parse_one(trimmed(rest.substr(0, equals)), rest.substr(equals + 1, end - equals - 1), signals);
    if (!setting) return tl::unexpected(setting.error());
    settings.push_back(*setting);
    rest.remove_prefix(end);
  }
  return settings;
}

}  // namespace driveline::cli
