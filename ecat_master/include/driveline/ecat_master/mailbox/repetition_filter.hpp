#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Finds the messages of a slave that repeat the previous one. A slave sends a message again only on request, with the
/// same counter (ETG.1000.4 6.6.3); counter 0 is not counted. Some slaves never advance their counter: as soon as that
/// is known, only a requested message is a repetition.
///
/// Not \rtsafe: keeps a copy of each message.
class RepetitionFilter {
 public:
  /// How the counter and content of a message compare with those of the previous one.
  enum class Novelty : std::uint8_t {
    kNew,          ///< another counter, or none
    kSameCounter,  ///< the same counter, but another message
    kRepetition,   ///< the same message again
  };
  /// Result of a comparison.
  struct Comparison {
    Novelty novelty;
    bool requested;  ///< the master has requested a repetition since the previous message
  };

  /// Compares a message with the previous one and keeps it for the next comparison. `mail`: header and service, without
  /// padding; `repeated`: how often the master has requested a repetition until now.
  [[nodiscard]] Comparison take(const wire::MailboxHeader& header, std::span<const std::byte> mail,
                                std::uint64_t repeated) {
    const Comparison comparison{compare(header, mail, repeated), repeated != last_repeated_};
    last_counter_ = header.counter;
    last_repeated_ = repeated;
    last_mail_.assign(mail.begin(), mail.end());
    uncounted_ = uncounted_ || comparison.novelty == Novelty::kSameCounter;
    return comparison;
  }

  /// From now on the slave counts as one that does not advance its counter.
  void expect_same_counter() noexcept { uncounted_ = true; }

 private:
  [[nodiscard]] Novelty compare(const wire::MailboxHeader& header, std::span<const std::byte> mail,
                                std::uint64_t repeated) const {
    if (header.counter == 0 || header.counter != last_counter_) return Novelty::kNew;
    if (!std::equal(mail.begin(), mail.end(), last_mail_.begin(), last_mail_.end())) return Novelty::kSameCounter;
    const bool requested = repeated != last_repeated_;
    return uncounted_ && !requested ? Novelty::kSameCounter : Novelty::kRepetition;
  }

  std::vector<std::byte> last_mail_;
  std::uint64_t last_repeated_ = 0;  ///< requested repetitions when it arrived
  std::uint8_t last_counter_ = 0;
  bool uncounted_ = false;  ///< the slave has given different messages the same counter
};

}  // namespace driveline::ecat_master
