#include "driveline/ecat_master/dc/sync_objects.hpp"

#include <algorithm>
#include <vector>

namespace driveline::ecat_master::dc {
namespace {

constexpr std::uint16_t kOutputParameter = 0x1C32;
constexpr std::uint16_t kInputParameter = 0x1C33;
constexpr std::uint8_t kType = 1;
constexpr std::uint8_t kCycle = 2;
constexpr std::uint8_t kEventsMissed = 0x0B;
constexpr std::uint8_t kDistanceMin = 0x11;
constexpr std::uint8_t kDistanceMax = 0x12;

/// Writes `value` to the entry of both objects, except those in `left_out`.
template <typename T>
Result<void> write_both(MailboxEngine& engine, std::uint16_t slave, std::uint8_t subindex, T value,
                        motion::WriteNeed need, const std::vector<std::uint16_t>& left_out, StartupNotes& notes) {
  SdoScript script{slave, {}};
  for (const auto index : {kOutputParameter, kInputParameter}) {
    if (std::find(left_out.begin(), left_out.end(), index) != left_out.end()) continue;
    auto& step = script.steps.emplace_back(SdoScript::Step::of<T>(index, subindex, value));
    step.need = need;
    step.compared = true;
  }
  return run_scripts(engine, {&script, 1}, &notes).front();
}

/// The objects that the slave does not have.
std::vector<std::uint16_t> missing_objects_in(const StartupNotes& notes) {
  std::vector<std::uint16_t> missing;
  for (const auto& note : notes) {
    const auto* refused = note.as<notes::WriteRefused>();
    if (refused != nullptr && refused->code == wire::SdoAbort::kObjectDoesNotExist)
      missing.push_back(refused->object.index);
  }
  return missing;
}

/// In DC mode the cycle may be read-only: the slave takes it from the SYNC0 register (ETG.1020, 1C32h:02).
bool is_read_only(const StartupNote& note) {
  const auto* refused = note.as<notes::WriteRefused>();
  return refused != nullptr && refused->code == wire::SdoAbort::kReadOnly;
}

/// The error for a mandatory write.
Error error_of(const StartupNote& note) {
  if (const auto* refused = note.as<notes::WriteRefused>())
    return {facts::SdoAbort{refused->object, refused->code}, note.slave};
  const auto& ignored = *note.as<notes::WriteIgnored>();
  return {facts::SyncObject{.object = ignored.object, .written = ignored.wanted, .read = ignored.present}, note.slave};
}

}  // namespace

Result<void> write_sync_objects(MailboxEngine& engine, std::uint16_t slave, const SyncSignals& signals,
                                motion::WriteNeed need, StartupNotes& notes) {
  if (need == motion::WriteNeed::kOmitted) return {};
  StartupNotes refused;
  const auto type = signals.sync0() ? kSyncTypeSync0 : kSyncTypeFreeRun;
  // The types first: a slave may accept a cycle only with the type that uses it.
  const auto typed = write_both<std::uint16_t>(engine, slave, kType, type, need, {}, refused);
  notes.insert(notes.end(), refused.begin(), refused.end());
  if (!typed || !signals.sync0()) return typed;
  StartupNotes cycles;
  const auto cycle = static_cast<std::uint32_t>(signals.sync0_cycle.count());
  const auto missing = missing_objects_in(refused);
  const auto done =
      write_both<std::uint32_t>(engine, slave, kCycle, cycle, motion::WriteNeed::kOptional, missing, cycles);
  if (!done) return done;
  std::erase_if(cycles, is_read_only);
  if (need == motion::WriteNeed::kMandatory && !cycles.empty()) return tl::unexpected(error_of(cycles.front()));
  notes.insert(notes.end(), cycles.begin(), cycles.end());
  return {};
}

Result<std::optional<SyncMarginReport>> read_sync_margin(CoeClient& coe) {
  const auto absent = [](const Error& error) {
    const auto* abort = error.as<facts::SdoAbort>();
    return abort != nullptr &&
           (abort->code == wire::SdoAbort::kObjectDoesNotExist || abort->code == wire::SdoAbort::kSubindexDoesNotExist);
  };
  SyncMarginReport report;
  for (const auto& [subindex, time] : {std::pair{kDistanceMin, &report.shortest}, {kDistanceMax, &report.longest}}) {
    const auto value = coe.upload_as<std::uint32_t>(kOutputParameter, subindex);
    if (!value && absent(value.error())) return std::nullopt;
    if (!value) return tl::unexpected(value.error());
    *time = std::chrono::nanoseconds{*value};
  }
  const auto missed = coe.upload_as<std::uint16_t>(kOutputParameter, kEventsMissed);
  if (!missed && !absent(missed.error())) return tl::unexpected(missed.error());
  report.missed = missed.value_or(std::uint16_t{0});
  return report;
}

}  // namespace driveline::ecat_master::dc
