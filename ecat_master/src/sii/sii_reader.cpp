#include "driveline/ecat_master/sii/sii_reader.hpp"

#include <algorithm>
#include <optional>

#include "driveline/wire/sii_access.hpp"

namespace driveline::ecat_master {
namespace {

namespace sii = wire::sii_access;
using std::chrono::milliseconds;

constexpr std::size_t kFirstCategoryWord = 0x40;
constexpr std::size_t kSizeWord = 0x3E;
constexpr std::size_t kMaxWords = 0x10000;
constexpr std::uint16_t kEndCategory = 0xFFFF;
/// ESC data sheet: an EEPROM answers within a few ms; real slaves were seen to need up to 10 ms.
constexpr auto kBusyTimeout = milliseconds{100};
constexpr std::size_t kInterfaceBytes = 14;  // control/status, address, data: 0x0502..0x050F

/// One slave's progress through its EEPROM.
struct Reading {
  SlaveRef slave;
  std::vector<std::byte> image;
  std::size_t needed_words = kFirstCategoryWord + 2;
  std::size_t category_word = kFirstCategoryWord;
  bool complete = false;
  bool arrived = false;
  std::optional<Error> failure;
  std::array<std::byte, kInterfaceBytes> interface {};

  [[nodiscard]] std::size_t words() const noexcept { return image.size() / 2; }
  [[nodiscard]] std::uint16_t word(std::size_t at) const noexcept {
    return wire::load_le<std::uint16_t>(std::span(image).subspan(2 * at, 2));
  }
};

Error sii_error(ErrorKind kind, const Reading& r, std::uint32_t code = 0) {
  Error error;
  error.kind = kind;
  error.slave = r.slave.position;
  error.address = static_cast<std::uint16_t>(r.words());
  error.code = code;
  return error;
}

/// Follows the chain of categories as far as it has been read. False: it does not end.
bool follow_categories(Reading& r) {
  // Word 0x3E holds the EEPROM size in KiBit minus one.
  const std::size_t size_words = std::min<std::size_t>((std::size_t{r.word(kSizeWord)} + 1) * 64, kMaxWords);
  while (r.words() >= r.category_word + 2) {
    if (r.word(r.category_word) == kEndCategory) {
      r.complete = true;
      return true;
    }
    r.category_word += 2 + r.word(r.category_word + 1);
    if (r.category_word > size_words) return false;
    // The end marker may be left out when the categories fill the EEPROM to the last word.
    const bool full = r.category_word == size_words;
    r.needed_words = full ? size_words : r.category_word + 2;
    if (full) break;
  }
  r.complete = r.category_word == size_words && r.words() >= size_words;
  return true;
}

Result<void> request_words(Bus& bus, std::span<Reading*> active) {
  std::vector<std::array<std::byte, 6>> commands(active.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < active.size(); ++i) {
    wire::store_le<std::uint16_t>(commands[i], sii::kCommandRead);
    wire::store_le<std::uint32_t>(std::span(commands[i]).subspan(2), static_cast<std::uint32_t>(active[i]->words()));
    requests.push_back({wire::Command::kFpwr,
                        wire::DatagramAddress::physical(active[i]->slave.station, wire::reg::kSiiControl.address),
                        commands[i]});
  }
  return bus.exchange().exchange(requests);
}

/// Polls until all of `active` have delivered; takes over the words.
Result<void> await_words(Bus& bus, std::span<Reading*> active) {
  for (auto* r : active) r->arrived = false;
  const auto deadline = bus.exchange().now() + kBusyTimeout;
  for (;;) {
    std::vector<Reading*> waiting;
    std::copy_if(active.begin(), active.end(), std::back_inserter(waiting),
                 [](const Reading* r) { return !r->arrived; });
    if (waiting.empty()) return {};
    std::vector<Request> requests;
    for (auto* r : waiting) {
      requests.push_back({wire::Command::kFprd,
                          wire::DatagramAddress::physical(r->slave.station, wire::reg::kSiiControl.address),
                          r->interface});
    }
    if (auto done = bus.exchange().exchange(requests); !done) return done;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      auto& r = *waiting[i];
      const auto status = wire::load_le<std::uint16_t>(r.interface);
      if (requests[i].working_counter != 1 || (status & sii::kBusy) != 0) continue;
      if ((status & (sii::kErrorAcknowledge | sii::kErrorWriteEnable)) != 0) {
        r.failure = sii_error(ErrorKind::kSiiError, r, status);
        r.arrived = true;
        continue;
      }
      const std::size_t bytes = (status & sii::kReads8Bytes) != 0 ? 8 : 4;
      r.image.insert(r.image.end(), r.interface.begin() + 6,
                     r.interface.begin() + 6 + static_cast<std::ptrdiff_t>(bytes));
      r.arrived = true;
    }
    if (bus.exchange().now() > deadline) {
      for (auto* r : active) {
        if (!r->arrived) r->failure = sii_error(ErrorKind::kSiiBusy, *r);
        r->arrived = true;
      }
    }
  }
}

Result<void> take_interface(Bus& bus) {
  // Forced take-over, then hand-over to EtherCAT (ETG.1000.4 6.4.3): a previous master may have left it to the PDI.
  for (const std::uint8_t value : {sii::kConfigForceEcat, std::uint8_t{0}}) {
    const auto data = wire::to_le_bytes(value);
    if (auto done = bus.broadcast_write(wire::reg::kSiiConfiguration.address, data); !done) {
      return tl::unexpected(done.error());
    }
  }
  return {};
}

}  // namespace

Result<std::vector<Result<std::vector<std::byte>>>> read_sii(Bus& bus, std::span<const SlaveRef> slaves) {
  if (auto taken = take_interface(bus); !taken) return tl::unexpected(taken.error());
  std::vector<Reading> readings;
  for (const auto& slave : slaves)
    readings.push_back({slave, {}, kFirstCategoryWord + 2, kFirstCategoryWord, false, false, std::nullopt, {}});
  for (;;) {
    std::vector<Reading*> active;
    for (auto& r : readings) {
      if (!r.complete && !r.failure) active.push_back(&r);
    }
    if (active.empty()) break;
    if (auto done = request_words(bus, active); !done) return tl::unexpected(done.error());
    if (auto done = await_words(bus, active); !done) return tl::unexpected(done.error());
    for (auto* r : active) {
      if (r->failure || r->words() < r->needed_words) continue;
      if (!follow_categories(*r)) r->failure = sii_error(ErrorKind::kSiiContent, *r);
    }
  }
  std::vector<Result<std::vector<std::byte>>> images;
  for (auto& r : readings) {
    if (r.failure) {
      images.emplace_back(tl::unexpected(*r.failure));
    } else {
      images.emplace_back(std::move(r.image));
    }
  }
  return images;
}

}  // namespace driveline::ecat_master
