#include "driveline/ecat_master/configuration/state_refusal.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "driveline/ecat_master/soe/soe_client.hpp"
#include "driveline/ecat_master/soe/soe_value.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::uint8_t kInvalidForPhase2 = 21;
constexpr std::uint8_t kInvalidForPhase3 = 22;
constexpr std::uint8_t kInvalidForPhase4 = 23;
constexpr wire::Idn kDiagnosticMessage{95};
/// Most drives of a slave (ETG.1000.6 5.9: three bits).
constexpr std::uint8_t kMostDrives = 8;
/// Most characters of a text of a drive in a note.
constexpr std::size_t kMostCharacters = 120;

std::vector<std::uint8_t> lists_for(wire::AlState refused) {
  if (refused == wire::AlState::kSafeOp) return {kInvalidForPhase2};
  return {kInvalidForPhase3, kInvalidForPhase4};
}

std::string short_text(std::string text) {
  if (text.size() > kMostCharacters) text.resize(kMostCharacters);
  return printable(std::move(text));
}

/// Asks the drives of one slave.
class Inquiry {
 public:
  Inquiry(MailboxEngine& engine, std::uint16_t position, StartupNotes& notes)
      : soe_(engine, position),
        exchange_(engine.bus().exchange()),
        end_(exchange_.now() + kRefusalReadingTime),
        position_(position),
        notes_(notes) {}

  /// Asks all drives; returns the first operation datum that a drive lists.
  facts::InvalidDatum run(wire::AlState refused, std::uint8_t drives) {
    const auto lists = lists_for(refused);
    for (std::uint8_t drive = 0; drive < (drives != 0 ? drives : kMostDrives); ++drive) {
      for (const auto list : lists) ask_for_list(drive, list);
      ask_for_message(drive);
      if (over_) break;
    }
    return first_;
  }

 private:
  /// Whether an answer can be used. A drive may refuse to answer; other failures, and the end of the time, end the
  /// inquiry.
  template <typename T>
  bool usable(const Result<T>& answer) {
    if (exchange_.now() >= end_) over_ = true;
    if (answer) return true;
    const auto* refused = answer.error().template as<facts::SoeRefused>();
    if (refused == nullptr || refused->code == wire::SoeError::kNoDrive) over_ = true;
    return false;
  }

  void ask_for_list(std::uint8_t drive, std::uint8_t list) {
    if (over_) return;
    const auto idns = soe_.idn_list({drive, {list}});
    if (!usable(idns)) return;
    for (std::size_t i = 0; i < idns->size() && i < kMostRefusalData && !over_; ++i) {
      ask_for_datum({drive, list, (*idns)[i]}, i + 1 == kMostRefusalData ? idns->size() - kMostRefusalData : 0);
    }
  }

  void ask_for_datum(const facts::InvalidDatum& invalid, std::size_t further) {
    if (first_.list == 0) first_ = invalid;
    notes::DatumRefusesState note{.invalid = invalid, .further = static_cast<std::uint16_t>(further)};
    const auto about = soe_.parameter({invalid.drive, invalid.idn});
    if (usable(about) && about->attribute) {
      const auto text = [&](const std::optional<std::vector<std::byte>>& bytes) {
        return bytes ? short_text(soe_value_text(*bytes, *about->attribute)) : std::string{};
      };
      note.name = short_text(about->name.value_or(""));
      note.unit = short_text(about->unit.value_or(""));
      note.value = text(about->value);
      note.minimum = text(about->min);
      note.maximum = text(about->max);
    }
    notes_.push_back({position_, std::move(note)});
  }

  void ask_for_message(std::uint8_t drive) {
    if (over_) return;
    const auto message = soe_.value({drive, kDiagnosticMessage});
    if (!usable(message) || message->empty()) return;
    std::string text;
    for (const auto byte : *message) text += static_cast<char>(byte);
    notes_.push_back({position_, notes::DriveDiagnosis{drive, short_text(std::move(text))}});
  }

  SoeClient soe_;
  DatagramExchange& exchange_;
  std::chrono::nanoseconds end_;
  std::uint16_t position_;
  StartupNotes& notes_;
  facts::InvalidDatum first_{};
  bool over_ = false;
};

}  // namespace

Error explain_by_drives(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves, const Error& error,
                        StartupNotes& notes) {
  const auto* refused = error.as<facts::StateRefused>();
  const auto slave = std::find_if(slaves.begin(), slaves.end(),
                                  [&](const ConfiguredSlave& one) { return one.info.ref.position == error.slave; });
  const bool asks = refused != nullptr && slave != slaves.end() && slave->mailbox &&
                    slave->info.description.mailbox.soe &&
                    (refused->requested == wire::AlState::kSafeOp || refused->requested == wire::AlState::kOp);
  if (!asks) return error;
  StartupNotes found;
  auto explained = *refused;
  const auto channels = std::min(slave->info.description.mailbox.soe_channels, kMostDrives);
  explained.invalid = Inquiry(engine, error.slave, found).run(refused->requested, channels);
  add_new(notes, found);
  return {explained, error.slave};
}

}  // namespace driveline::ecat_master
