#include "driveline/ecat_master/dc/sync_objects.hpp"

namespace driveline::ecat_master::dc {
namespace {

constexpr std::uint16_t kOutputParameter = 0x1C32;
constexpr std::uint16_t kInputParameter = 0x1C33;
constexpr std::uint8_t kType = 1;
constexpr std::uint8_t kCycle = 2;
constexpr std::uint8_t kEventsMissed = 0x0B;
constexpr std::uint8_t kDistanceMin = 0x11;
constexpr std::uint8_t kDistanceMax = 0x12;

enum class Written { kYes, kReadOnly, kMissing };

Result<Written> outcome(const Result<void>& download) {
  if (download) return Written::kYes;
  const auto& error = download.error();
  if (const auto* abort = error.as<facts::SdoAbort>()) {
    switch (abort->code) {
      case wire::SdoAbort::kReadOnly:
        return Written::kReadOnly;
      case wire::SdoAbort::kObjectDoesNotExist:
      case wire::SdoAbort::kSubindexDoesNotExist:
        return Written::kMissing;
      default:
        break;
    }
  }
  return tl::unexpected(error);
}

template <typename T>
Result<Written> write_and_compare(CoeClient& coe, std::uint16_t slave, std::uint16_t index, std::uint8_t subindex,
                                  T value) {
  const auto written = outcome(coe.download_as<T>(index, subindex, value));
  if (!written || *written == Written::kMissing) return written;
  if (*written == Written::kReadOnly && subindex == kCycle) return written;
  const auto read = coe.upload_as<T>(index, subindex);
  if (!read) return tl::unexpected(read.error());
  if (*read == value) return written;
  return tl::unexpected(Error{facts::SyncObject{.object = {index, subindex}, .written = value, .read = *read}, slave});
}

}  // namespace

Result<void> write_sync_objects(CoeClient& coe, std::uint16_t slave, const SyncSignals& signals) {
  const auto type = signals.sync0() ? kSyncTypeSync0 : kSyncTypeFreeRun;
  const auto cycle = static_cast<std::uint32_t>(signals.sync0_cycle.count());
  for (const auto index : {kOutputParameter, kInputParameter}) {
    const auto written = write_and_compare<std::uint16_t>(coe, slave, index, kType, type);
    if (!written) return tl::unexpected(written.error());
    if (*written == Written::kMissing || !signals.sync0()) continue;
    if (const auto done = write_and_compare<std::uint32_t>(coe, slave, index, kCycle, cycle); !done)
      return tl::unexpected(done.error());
  }
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
