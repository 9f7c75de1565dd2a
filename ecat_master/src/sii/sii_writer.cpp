#include "driveline/ecat_master/sii/sii_writer.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "bus/poll_timeout.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/wire/sii_access.hpp"
#include "sii/sii_ownership.hpp"

namespace driveline::ecat_master {
namespace {

namespace sii = wire::sii_access;
using std::chrono::milliseconds;

constexpr std::size_t kConfigWords = 8;
/// An EEPROM is busy for up to 10 ms after a word and does not acknowledge during this time.
constexpr auto kWriteBusyTimeout = milliseconds{500};
constexpr auto kPause = milliseconds{1};
constexpr int kTries = 10;
/// After this many consecutive words that cannot be restored, the restoring ends.
constexpr int kMaxRestoreFailures = 3;

std::uint16_t word_at(std::span<const std::byte> bytes, std::size_t word) {
  return bytes::load_le<std::uint16_t>(bytes.subspan(2 * word, 2));
}

std::uint16_t narrow(std::size_t word) {
  return static_cast<std::uint16_t>(word);
}

/// The EEPROM interface of a slave (ETG.1000.4 6.4). Returns it to the application if that had it before.
class SiiInterfaceAccess {
 public:
  SiiInterfaceAccess(Bus& bus, SlaveRef slave) : bus_(bus), slave_(slave) {}
  SiiInterfaceAccess(const SiiInterfaceAccess&) = delete;
  SiiInterfaceAccess& operator=(const SiiInterfaceAccess&) = delete;
  // A slave that does not answer now has lost the interface anyway.
  ~SiiInterfaceAccess() { static_cast<void>(give_to_applications(bus_, owned_)); }

  /// Takes the interface from the application.
  Result<void> take() {
    auto owned = take_from_applications(bus_, {&slave_, 1});
    if (!owned) return tl::unexpected(owned.error());
    owned_.insert(owned_.end(), owned->begin(), owned->end());
    return {};
  }

  /// The bytes of a read command, 4 or 8.
  Result<std::vector<std::byte>> read(std::size_t word) {
    return attempt(word, [&] { return command(sii::kCommandRead, word, {}); });
  }

  Result<void> write(std::size_t word, std::uint16_t value) {
    const auto data = bytes::to_le_bytes(value);
    auto done = attempt(word, [&] { return command(sii::kCommandWrite | sii::kWriteEnable, word, data); });
    if (!done) return tl::unexpected(done.error());
    return {};
  }

  [[nodiscard]] Error error(ErrorFacts facts) const { return {facts, slave_.position}; }

 private:
  /// Repeats an access that the EEPROM did not acknowledge; returns on any other error.
  template <typename Try>
  Result<std::vector<std::byte>> attempt(std::size_t word, Try what) {
    Result<std::vector<std::byte>> result = tl::unexpected(error(facts::SiiBusy{narrow(word)}));
    for (int i = 0; i < kTries; ++i) {
      result = what();
      if (result || !result.error().is<facts::SiiError>()) return result;
      bus_.exchange().pause(kPause);
    }
    return result;
  }

  Result<std::vector<std::byte>> command(unsigned control, std::size_t word, std::span<const std::byte> data) {
    std::vector<std::byte> request(6 + data.size());
    bytes::store_le<std::uint16_t>(request, static_cast<std::uint16_t>(control));
    bytes::store_le<std::uint32_t>(std::span(request).subspan(2), static_cast<std::uint32_t>(word));
    std::copy(data.begin(), data.end(), request.begin() + 6);
    if (auto done = give(word, request); !done) return tl::unexpected(done.error());
    const auto status = wait_idle(word);
    if (!status) return tl::unexpected(status.error());
    const auto flags = bytes::load_le<std::uint16_t>(*status);
    if ((flags & (sii::kErrorAcknowledge | sii::kErrorWriteEnable)) != 0) {
      return tl::unexpected(error(facts::SiiError{.word = narrow(word), .status = flags}));
    }
    const std::size_t bytes = (flags & sii::kReads8Bytes) != 0 ? 8 : 4;
    return std::vector<std::byte>(status->begin() + 6, status->begin() + 6 + static_cast<std::ptrdiff_t>(bytes));
  }

  /// A busy interface ignores commands, whatever its status was just before (ESC data sheet II, 0x0502).
  Result<void> give(std::size_t word, std::span<const std::byte> request) {
    PollTimeout poll_timeout(bus_.exchange().now(), kWriteBusyTimeout);
    for (;;) {
      if (auto ready = wait_idle(word); !ready) return tl::unexpected(ready.error());
      const auto done = bus_.write(slave_, wire::reg::kSiiControl.address, request);
      if (done || !done.error().is<facts::WorkingCounter>()) return done;
      if (poll_timeout.over(bus_.exchange().now())) return tl::unexpected(error(facts::SiiBusy{narrow(word)}));
      bus_.exchange().pause(kPause);
    }
  }

  Result<std::array<std::byte, sii::kInterfaceBytes>> wait_idle(std::size_t word) {
    PollTimeout poll_timeout(bus_.exchange().now(), kWriteBusyTimeout);
    for (;;) {
      std::array<std::byte, sii::kInterfaceBytes> data{};
      if (auto done = bus_.read(slave_, wire::reg::kSiiControl.address, data); !done) {
        return tl::unexpected(done.error());
      }
      if ((bytes::load_le<std::uint16_t>(data) & sii::kBusy) == 0) return data;
      if (poll_timeout.over(bus_.exchange().now())) return tl::unexpected(error(facts::SiiBusy{narrow(word)}));
      bus_.exchange().pause(kPause);
    }
  }

  Bus& bus_;
  SlaveRef slave_;
  std::vector<SlaveRef> owned_;  ///< this slave, if its application had the interface
};

Result<std::vector<std::byte>> read_range(SiiInterfaceAccess& access, std::size_t first, std::size_t count) {
  std::vector<std::byte> bytes;
  while (bytes.size() < 2 * count) {
    const auto part = access.read(first + bytes.size() / 2);
    if (!part) return tl::unexpected(part.error());
    bytes.insert(bytes.end(), part->begin(), part->end());
  }
  bytes.resize(2 * count);
  return bytes;
}

/// A word with its new value.
struct Change {
  std::size_t word = 0;
  std::uint16_t value = 0;
};

/// A checksum word that matches neither configuration area and does not disable the check.
std::uint16_t invalid_checksum(std::span<const std::byte> before, std::span<const std::byte> after) {
  const auto crc = [](std::span<const std::byte> image) {
    return esi::sii_checksum(image.first<esi::SiiConfigArea::kSize>());
  };
  std::uint16_t value = 0x00FF;
  while ((value & 0xFF) == crc(before) || (value & 0xFF) == crc(after)) --value;
  return value;
}

/// The writes in order; see write_sii().
std::vector<Change> plan(std::span<const std::byte> before, std::span<const std::byte> after) {
  std::vector<Change> changes;
  const auto add = [&](std::size_t first, std::size_t last) {
    for (std::size_t word = first; word < last; ++word) {
      if (word_at(before, word) != word_at(after, word)) changes.push_back({word, word_at(after, word)});
    }
  };
  add(0, sii::kChecksumWord);
  const std::size_t in_config_area = changes.size();
  changes.clear();
  add(kConfigWords, after.size() / 2);
  // A single word of the configuration area followed by its checksum cannot be mistaken for complete in between.
  const bool marked = !changes.empty() || in_config_area > 1;
  if (marked) changes.insert(changes.begin(), Change{sii::kChecksumWord, invalid_checksum(before, after)});
  add(0, sii::kChecksumWord);
  if (marked) {
    changes.push_back({sii::kChecksumWord, word_at(after, sii::kChecksumWord)});
  } else {
    add(sii::kChecksumWord, kConfigWords);
  }
  return changes;
}

Result<void> write_and_check(SiiInterfaceAccess& access, const Change& change) {
  if (auto done = access.write(change.word, change.value); !done) return done;
  const auto back = access.read(change.word);
  if (!back) return tl::unexpected(back.error());
  const auto found = word_at(*back, 0);
  if (found == change.value) return {};
  return tl::unexpected(
      access.error(facts::SiiVerify{.word = narrow(change.word), .written = change.value, .read = found}));
}

/// Restores a word. A word that could not be written may still hold its old value.
bool put_back(SiiInterfaceAccess& access, const Change& change) {
  const auto now = access.read(change.word);
  if (now && word_at(*now, 0) == change.value) return true;
  return now && write_and_check(access, change);
}

/// Restores words in reverse order of writing; returns the words that may differ from before.
std::vector<std::uint16_t> restore(SiiInterfaceAccess& access, std::span<const Change> written,
                                   std::span<const std::byte> before) {
  std::vector<std::uint16_t> left;
  int failures = 0;
  for (auto change = written.rbegin(); change != written.rend(); ++change) {
    const bool gives_up = failures >= kMaxRestoreFailures;
    if (!gives_up && put_back(access, {change->word, word_at(before, change->word)})) {
      failures = 0;
    } else {
      ++failures;
      left.push_back(static_cast<std::uint16_t>(change->word));
    }
  }
  std::sort(left.begin(), left.end());
  left.erase(std::unique(left.begin(), left.end()), left.end());
  return left;
}

Result<void> check_all(SiiInterfaceAccess& access, std::span<const std::byte> image) {
  const auto back = read_range(access, 0, image.size() / 2);
  if (!back) return tl::unexpected(back.error());
  for (std::size_t word = 0; word < image.size() / 2; ++word) {
    if (word_at(*back, word) == word_at(image, word)) continue;
    return tl::unexpected(access.error(
        facts::SiiVerify{.word = narrow(word), .written = word_at(image, word), .read = word_at(*back, word)}));
  }
  return {};
}

Result<void> write_all(SiiInterfaceAccess& access, std::span<const Change> changes, const SiiProgress& progress,
                       std::size_t& written) {
  for (const auto& change : changes) {
    ++written;  // a word whose write fails may have been written nevertheless
    if (auto done = write_and_check(access, change); !done) return done;
    if (progress && !progress(written, changes.size())) {
      return tl::unexpected(access.error(facts::Cancelled{}));
    }
  }
  return {};
}

/// "0x0007, 0x0041-0x0043"
std::string ranges(std::span<const std::uint16_t> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size();) {
    std::size_t last = i;
    while (last + 1 < words.size() && words[last + 1] == words[last] + 1) ++last;
    text += fmt::format("{}0x{:04X}", text.empty() ? "" : ", ", words[i]);
    if (last > i) text += fmt::format("-0x{:04X}", words[last]);
    i = last + 1;
  }
  return text;
}

}  // namespace

Result<std::vector<std::byte>> read_sii_words(Bus& bus, SlaveRef slave, std::size_t first, std::size_t count) {
  SiiInterfaceAccess access(bus, slave);
  if (auto taken = access.take(); !taken) return tl::unexpected(taken.error());
  return read_range(access, first, count);
}

tl::expected<SiiWriteReport, SiiWriteFailure> write_sii(Bus& bus, SlaveRef slave, std::span<const std::byte> image,
                                                        const SiiProgress& progress) {
  SiiInterfaceAccess access(bus, slave);
  const auto fail_before = [](const Error& error) { return tl::unexpected(SiiWriteFailure{error, 0, {}, {}}); };
  if (image.size() % 2 != 0 || image.size() < 2 * kConfigWords || image.size() / 2 > 0x10000) {
    return fail_before(access.error(facts::SiiContent{narrow(image.size() / 2)}));
  }
  if (auto taken = access.take(); !taken) return fail_before(taken.error());
  bus.sii_cache().clear();
  auto before = read_range(access, 0, image.size() / 2);
  if (!before) return fail_before(before.error());

  const auto changes = plan(*before, image);
  std::size_t written = 0;
  auto done = write_all(access, changes, progress, written);
  if (done) done = check_all(access, image);
  if (!done) {
    auto left = restore(access, std::span(changes).first(written), *before);
    return tl::unexpected(SiiWriteFailure{done.error(), written, std::move(left), std::move(*before)});
  }
  std::size_t unchanged = 0;
  for (std::size_t word = 0; word < image.size() / 2; ++word) {
    unchanged += word_at(*before, word) == word_at(image, word) ? 1 : 0;
  }
  return SiiWriteReport{image.size() / 2 - unchanged, unchanged, std::move(*before)};
}

tl::expected<SiiWriteReport, SiiWriteFailure> write_alias(Bus& bus, SlaveRef slave, std::uint16_t alias) {
  auto image = read_sii_words(bus, slave, 0, kConfigWords);
  if (!image) return tl::unexpected(SiiWriteFailure{image.error(), 0, {}, {}});
  const auto area = std::span(*image).first<esi::SiiConfigArea::kSize>();
  if ((word_at(*image, sii::kChecksumWord) & 0xFF) != esi::sii_checksum(area)) {
    const SiiInterfaceAccess access(bus, slave);
    const auto error = access.error(facts::SiiContent{sii::kChecksumWord});
    return tl::unexpected(SiiWriteFailure{error, 0, {}, {}});
  }
  bytes::store_le(std::span(*image).subspan(2 * sii::kAliasWord, 2), alias);
  const std::uint16_t high = word_at(*image, sii::kChecksumWord) & 0xFF00U;
  bytes::store_le(std::span(*image).subspan(2 * sii::kChecksumWord, 2),
                  static_cast<std::uint16_t>(high | esi::sii_checksum(area)));
  return write_sii(bus, slave, *image);
}

std::string describe(const SiiWriteFailure& failure) {
  const auto reason = describe(failure.error);
  if (failure.words_written == 0) return reason + "; nothing has been written";
  if (failure.left.empty()) return reason + "; the words written were restored, the EEPROM has its previous content";
  return fmt::format(
      "{}; {} words could not be restored and may have any value: {}; the EEPROM is unusable until it is written again",
      reason, failure.left.size(), ranges(failure.left));
}

}  // namespace driveline::ecat_master
