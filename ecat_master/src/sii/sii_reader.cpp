#include "sii/sii_reader.hpp"

#include <algorithm>
#include <optional>

#include "bus/poll_timeout.hpp"
#include "driveline/wire/sii_access.hpp"
#include "sii/sii_ownership.hpp"

namespace driveline::ecat_master {
namespace {

namespace sii = wire::sii_access;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::size_t kFirstCategoryWord = 0x40;
constexpr std::size_t kSizeWord = 0x3E;
constexpr std::size_t kMaxWords = 0x10000;
constexpr std::uint16_t kEndCategory = 0xFFFF;
/// ESC data sheet: an EEPROM answers within a few ms; some real slaves need up to 10 ms.
constexpr auto kReadBusyTimeout = milliseconds{100};
constexpr std::size_t kCommandBytes = 6;  // control, address: 0x0502..0x0507
constexpr std::size_t kAddressAt = 2;
constexpr std::size_t kDataAt = 6;
/// Words per read command: 4 bytes, until the slave reports that it reads 8.
constexpr std::size_t kFewWords = 2;
constexpr std::size_t kManyWords = 4;
/// Read commands with their answers per round: at first, and when all goes well; the latter fill a frame.
constexpr std::size_t kFirstDepth = 8;
constexpr std::size_t kFullDepth = 32;
/// Consecutive answers with another address after which the slave is assumed not to report the address.
constexpr int kMaxForeignAddresses = 3;

/// A read command, a read of the slave's interface registers, or both, in the order of the mode.
struct Step {
  std::size_t word = 0;
  std::array<std::byte, kCommandBytes> command{};
  std::array<std::byte, sii::kInterfaceBytes> answer{};
  bool commands = false;
  bool looks = false;
};

/// Progress of a slave's EEPROM read.
///
/// A slave controller applies register writes at the end of a frame, and accepts commands only while its interface is
/// idle (ESC data sheet I "Shadow buffer", II 0x0502); so the answer to a command usually arrives in a later frame, and
/// the next command travels with the poll for it. Controllers that execute a command within the frame get many commands
/// per frame, each followed by its poll. Neither is assumed: an answer counts when the interface is idle and shows the
/// address of the wanted word. The first word is requested in a frame of its own, since the address may be that of an
/// earlier reader.
class Reading {
 public:
  Reading(SlaveRef slave, nanoseconds now) : slave_(slave), poll_timeout_(now, kReadBusyTimeout) {}

  [[nodiscard]] bool done() const noexcept { return complete_ || failure_.has_value(); }
  [[nodiscard]] Result<std::vector<std::byte>> take() {
    if (failure_) return tl::unexpected(*failure_);
    return std::move(image_);
  }

  /// Appends the datagrams of the next round, which refer to this object.
  void prepare(std::vector<Request>& requests) {
    make_steps();
    const auto address = wire::DatagramAddress::physical(slave_.station, wire::reg::kSiiControl.address);
    for (auto& step : steps_) {
      const Request look{wire::Command::kFprd, address, step.answer};
      if (step.looks && mode_ != Mode::kPairs) requests.push_back(look);
      if (step.commands) {
        bytes::store_le<std::uint16_t>(step.command, sii::kCommandRead);
        bytes::store_le<std::uint32_t>(std::span(step.command).subspan(kAddressAt),
                                       static_cast<std::uint32_t>(step.word));
        requests.push_back({wire::Command::kFpwr, address, step.command});
      }
      if (step.looks && mode_ == Mode::kPairs) requests.push_back(look);
    }
  }

  /// Processes the answers; `answers` starts with the datagrams of this slave. Returns their number.
  std::size_t evaluate(std::span<const Request> answers, nanoseconds now, const SiiCache& cache) {
    std::size_t used = 0;
    bool looked = true;
    for (auto& step : steps_) {
      const auto count = (step.looks ? 1U : 0U) + (step.commands ? 1U : 0U);
      for (const auto& answer : answers.subspan(used, count)) {
        const bool touched = answer.working_counter == 1;
        if (answer.command == wire::Command::kFpwr) {
          step.commands = touched;  // a busy interface may ignore it
        } else {
          looked = looked && touched;
        }
      }
      used += count;
    }
    const auto before = words();
    if (looked) evaluate();
    if (words() > before) {
      poll_timeout_.begin(now);
      look_up_content(cache);
    }
    if (!done() && poll_timeout_.over(now)) fail(facts::SiiBusy{next_word()});
    return used;
  }

 private:
  enum class Mode : std::uint8_t {
    kCommand,  ///< sends a command when the interface is idle
    kAwait,    ///< polls for the answer; the next command may follow the poll
    kPairs,    ///< sends commands, each followed by its poll
  };
  enum class Answer : std::uint8_t { kTaken, kBusy, kOther, kFailed };

  void make_steps() {
    steps_.clear();
    if (mode_ == Mode::kPairs) {
      for (std::size_t i = 0; i < depth_; ++i) {
        const std::size_t word = words() + i * words_per_read_;
        if (i > 0 && word >= limit()) break;
        steps_.push_back({word, {}, {}, true, true});
      }
    } else if (mode_ == Mode::kCommand) {
      steps_.push_back({words(), {}, {}, true, true});
    } else {
      const std::size_t next = words() + words_per_read_;
      steps_.push_back({next, {}, {}, next_travels_ && next < limit(), true});
    }
  }

  void evaluate() {
    const auto& first = steps_.front();
    if (mode_ == Mode::kCommand) {
      const auto status = bytes::load_le<std::uint16_t>(first.answer);
      if ((status & sii::kBusy) == 0 && first.commands) mode_ = Mode::kAwait;
    } else if (mode_ == Mode::kAwait) {
      evaluate_awaited(first);
    } else {
      evaluate_pairs();
    }
  }

  void evaluate_awaited(const Step& step) {
    switch (take_answer(step.answer)) {
      case Answer::kTaken:
        // Find out whether this controller executes commands within a frame.
        mode_ = !tried_pairs_ ? Mode::kPairs : step.commands ? Mode::kAwait : Mode::kCommand;
        tried_pairs_ = true;
        foreign_addresses_ = 0;
        break;
      case Answer::kOther:
        mode_ = Mode::kCommand;
        if (++foreign_addresses_ == kMaxForeignAddresses) {
          shows_address_ = false;
          next_travels_ = false;
          tried_pairs_ = true;
        }
        break;
      case Answer::kBusy:
      case Answer::kFailed:
        break;
    }
  }

  void evaluate_pairs() {
    for (const auto& step : steps_) {
      // If the slave changed the number of bytes per read, later answers start at other words.
      if (step.word == words() && take_answer(step.answer) == Answer::kTaken) {
        pairs_work_ = true;
        continue;
      }
      // It is unknown which command, if any, was accepted at the end of the frame. Once proven, pairs are tried again:
      // a frame may have been lost.
      mode_ = Mode::kCommand;
      next_travels_ = true;
      tried_pairs_ = !pairs_work_;
      return;
    }
    depth_ = kFullDepth;
  }

  /// Appends the words in `answer` if they are the wanted ones.
  Answer take_answer(std::span<const std::byte, sii::kInterfaceBytes> answer) {
    const auto status = bytes::load_le<std::uint16_t>(answer);
    if ((status & sii::kBusy) != 0) return Answer::kBusy;
    const auto shown = bytes::load_le<std::uint32_t>(answer.subspan(kAddressAt));
    if (shows_address_ && shown != words()) return Answer::kOther;
    if ((status & (sii::kErrorAcknowledge | sii::kErrorWriteEnable)) != 0) {
      fail(facts::SiiError{.word = next_word(), .status = status});
      return Answer::kFailed;
    }
    words_per_read_ = (status & sii::kReads8Bytes) != 0 ? kManyWords : kFewWords;
    const auto data = answer.subspan(kDataAt, 2 * words_per_read_);
    image_.insert(image_.end(), data.begin(), data.end());
    return Answer::kTaken;
  }

  [[nodiscard]] std::size_t words() const noexcept { return image_.size() / 2; }
  [[nodiscard]] std::uint16_t word(std::size_t at) const noexcept {
    return bytes::load_le<std::uint16_t>(std::span(image_).subspan(2 * at, 2));
  }
  /// End of the words that may be read. Word 0x3E holds the EEPROM size in KiBit minus one.
  [[nodiscard]] std::size_t limit() const noexcept {
    if (words() <= kSizeWord) return SiiCache::kHeadWords;
    return std::min<std::size_t>((std::size_t{word(kSizeWord)} + 1) * 64, kMaxWords);
  }

  /// The first word that has not been read yet.
  [[nodiscard]] std::uint16_t next_word() const noexcept { return static_cast<std::uint16_t>(words()); }
  void fail(ErrorFacts facts) { failure_ = Error{facts, slave_.position}; }

  /// Checks whether the content is complete, in the cache, or without an end.
  void look_up_content(const SiiCache& cache) {
    if (!looked_up_ && words() >= SiiCache::kHeadWords) {
      looked_up_ = true;
      if (auto known = cache.find(image_)) {
        image_ = std::move(*known);
        complete_ = true;
        return;
      }
    }
    if (words() < needed_words_) return;
    if (!follow_categories()) return fail(facts::SiiContent{next_word()});
    // Drop words read beyond the end.
    if (complete_)
      image_.resize(
          std::min(image_.size(), 2 * ((needed_words_ + words_per_read_ - 1) / words_per_read_ * words_per_read_)));
  }

  /// Follows the chain of categories as far as it has been read. Returns false when it does not end.
  bool follow_categories() {
    const std::size_t size_words = limit();
    while (words() >= category_word_ + 2) {
      if (word(category_word_) == kEndCategory) {
        complete_ = true;
        return true;
      }
      category_word_ += 2 + word(category_word_ + 1);
      if (category_word_ > size_words) return false;
      // The end marker may be missing when the categories fill the EEPROM completely.
      const bool full = category_word_ == size_words;
      needed_words_ = full ? size_words : category_word_ + 2;
      if (full) break;
    }
    complete_ = category_word_ == size_words && words() >= size_words;
    return true;
  }

  SlaveRef slave_;
  std::vector<std::byte> image_;
  std::vector<Step> steps_;
  Mode mode_ = Mode::kCommand;
  std::size_t needed_words_ = SiiCache::kHeadWords;
  std::size_t category_word_ = kFirstCategoryWord;
  std::size_t words_per_read_ = kFewWords;
  std::size_t depth_ = kFirstDepth;
  int foreign_addresses_ = 0;
  bool shows_address_ = true;
  bool tried_pairs_ = false;
  bool pairs_work_ = false;
  bool next_travels_ = false;  ///< commands do not take effect within their frame
  bool looked_up_ = false;
  bool complete_ = false;
  PollTimeout poll_timeout_;
  std::optional<Error> failure_;
};

/// One round for all incomplete readings.
Result<void> read_on(Bus& bus, std::span<Reading*> active) {
  std::vector<Request> requests;
  for (auto* reading : active) reading->prepare(requests);
  if (auto done = bus.exchange().exchange(requests); !done) return done;
  std::span<const Request> answers = requests;
  const auto now = bus.exchange().now();
  for (auto* reading : active) answers = answers.subspan(reading->evaluate(answers, now, bus.sii_cache()));
  return {};
}

}  // namespace

Result<std::vector<Result<std::vector<std::byte>>>> read_sii(Bus& bus, std::span<const SlaveRef> slaves) {
  const auto owned = take_from_applications(bus, slaves);
  if (!owned) return tl::unexpected(owned.error());
  std::vector<Reading> readings;
  for (const auto& slave : slaves) readings.emplace_back(slave, bus.exchange().now());
  for (;;) {
    std::vector<Reading*> active;
    for (auto& reading : readings) {
      if (!reading.done()) active.push_back(&reading);
    }
    if (active.empty()) break;
    if (auto done = read_on(bus, active); !done) return tl::unexpected(done.error());
  }
  std::vector<Result<std::vector<std::byte>>> images;
  for (auto& reading : readings) {
    images.push_back(reading.take());
    if (images.back()) bus.sii_cache().keep(*images.back());
  }
  // Only a slave that no longer answers gets nothing back; its images are right nevertheless.
  static_cast<void>(give_to_applications(bus, *owned));
  return images;
}

}  // namespace driveline::ecat_master
