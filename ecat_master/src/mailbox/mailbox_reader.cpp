#include "driveline/ecat_master/mailbox/mailbox_reader.hpp"

#include "driveline/wire/registers.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using std::chrono::nanoseconds;

/// Register offsets inside a sync manager channel.
constexpr std::uint16_t kStatusOffset = 5;
constexpr std::uint16_t kActivateOffset = 6;
constexpr std::uint16_t kPdiControlOffset = 7;
constexpr unsigned kIn = 1;
/// Consecutive unanswered polls after which a slave counts as gone: a port that opens or closes costs one poll.
constexpr unsigned kSilentPolls = 3;
/// Time limit for the acknowledge of a repeat request when the mailbox is full.
constexpr auto kRepeatTimeout = std::chrono::milliseconds{100};

std::uint16_t in_register(std::uint16_t offset) {
  return static_cast<std::uint16_t>(wire::reg::kSyncManager.at(kIn) + offset);
}

bool is_set(std::byte value, std::uint8_t bits) {
  return (value & std::byte{bits}) != std::byte{0};
}

}  // namespace

MailboxReader::MailboxReader(SlaveRef slave, const MailboxWindow& window, nanoseconds timeout, nanoseconds idle_poll)
    : slave_(slave), address_(window.in_address), timeout_(timeout), idle_poll_(idle_poll) {
  for (auto& buffer : wire_) buffer.resize(window.in_length);
}

std::uint16_t MailboxReader::status_register() noexcept {
  return in_register(kStatusOffset);
}

void MailboxReader::poll_now() noexcept {
  next_idle_poll_ = {};
  sample_is_old_ = true;
}

void MailboxReader::expect_more() noexcept {
  if (fetch_ == Fetch::kPoll) fetch_ = Fetch::kGuess;
}

void MailboxReader::use_sample(std::optional<MailboxStatusSample> sample) noexcept {
  sample_ = sample;
  if (!sample_ || !sample_is_old_) return;
  // The frame of the current cycle may have passed the slave before the mailbox was read; that of the next cycle has
  // not.
  sample_from_ = sample_->cycle + 2;
  sample_is_old_ = false;
}

void MailboxReader::begin(Fetch fetch, nanoseconds now) noexcept {
  fetch_ = fetch;
  deadline_ = now + timeout_;
}

/// Whether the next datagram concerns the mailbox. With a status sample the only such datagram is the read of a full
/// mailbox.
bool MailboxReader::wants_poll(nanoseconds now, bool awaited) noexcept {
  if (!sample_) return awaited || now >= next_idle_poll_;
  if (sample_->cycle < sample_from_) return false;
  if (sample_->full) {
    begin(Fetch::kRead, now);
    return true;
  }
  next_idle_poll_ = now + idle_poll_;
  return false;
}

bool MailboxReader::append(nanoseconds now, bool awaited, std::vector<Request>& batch) {
  if (fetch_ == Fetch::kPoll && !wants_poll(now, awaited)) return false;
  switch (fetch_) {
    case Fetch::kPoll:
      append(wire::Command::kFprd, status_register(), std::span(registers_).first(1), batch);
      break;
    case Fetch::kRead:
    case Fetch::kGuess:
      append_read(batch);
      break;
    case Fetch::kRepeatLook:
    case Fetch::kRepeatWait:
      append(wire::Command::kFprd, status_register(), registers_, batch);
      break;
    case Fetch::kRepeatToggle:
      append(wire::Command::kFpwr, in_register(kActivateOffset), std::span(registers_).subspan(1, 1), batch);
      break;
  }
  return true;
}

void MailboxReader::append(wire::Command command, std::uint16_t address, std::span<std::byte> data,
                           std::vector<Request>& batch) {
  batch.push_back({command, wire::DatagramAddress::physical(slave_.station, address), data, 0, false});
}

void MailboxReader::append_read(std::vector<Request>& batch) {
  side_ = 1 - side_;
  append(wire::Command::kFprd, address_, wire_.at(side_), batch);
  batch.back().once = true;
}

MailboxReader::Ahead MailboxReader::append_ahead(bool reading, std::size_t expected, std::vector<Request>& batch) {
  if (repeats()) return Ahead::kNothing;
  const bool sampled = sample_ && sample_->full && !sample_is_old_ && sample_->cycle >= sample_from_;
  const bool looked = fetch_ == Fetch::kRead && !reading;
  if (sampled || looked || expected > (reading ? 1U : 0U)) {
    append_read(batch);
    return Ahead::kRead;
  }
  if (sample_) return Ahead::kNothing;
  side_ = 1 - side_;
  append(wire::Command::kFprd, status_register(), polls_.at(side_), batch);
  return Ahead::kPoll;
}

MailboxReader::Found MailboxReader::take_ahead(nanoseconds now, Ahead what, const Request& answer) {
  if (answer.withheld || repeats()) return Found::kNothing;
  if (what == Ahead::kRead) {
    fetch_ = Fetch::kGuess;
    return take(now, answer);
  }
  // The previous poll has already found a message.
  if (fetch_ == Fetch::kRead) return Found::kNothing;
  fetch_ = Fetch::kPoll;
  registers_[0] = answer.data[0];
  return take(now, answer);
}

MailboxReader::Found MailboxReader::take(nanoseconds now, const Request& answer) {
  const bool touched = answer.working_counter != 0;
  if (fetch_ == Fetch::kPoll) return take_status(now, touched);
  const bool reads = fetch_ == Fetch::kRead || fetch_ == Fetch::kGuess;
  const auto found = reads ? take_read(now, answer) : take_repeat(now, touched);
  if (fetch_ != Fetch::kPoll && now >= deadline_) fetch_ = Fetch::kPoll;
  return found;
}

MailboxReader::Found MailboxReader::take_status(nanoseconds now, bool touched) {
  next_idle_poll_ = now + idle_poll_;
  if (!touched) return ++silent_ < kSilentPolls ? Found::kNothing : Found::kSilence;
  silent_ = 0;
  if (!is_set(registers_[0], wire::SyncManagerStatus::kMailboxFull)) return Found::kNothing;
  begin(Fetch::kRead, now);
  return Found::kStep;
}

/// Handles a failed read. The mailbox was empty, or the read was lost in transit: the slave may already have released
/// the content, so it must repeat it. A second read could return the next message.
MailboxReader::Found MailboxReader::take_read(nanoseconds now, const Request& answer) {
  const bool guessed = fetch_ == Fetch::kGuess;
  if (guessed) begin(Fetch::kPoll, now);
  if (answer.working_counter != 0) {
    fetch_ = Fetch::kPoll;
    mail_ = answer.data;
    return Found::kMail;
  }
  if (guessed && answer.answered) {
    next_idle_poll_ = now + idle_poll_;
    return Found::kNothing;
  }
  fetch_ = Fetch::kRepeatLook;
  return Found::kStep;
}

/// Toggles the repeat request, waits for the acknowledge, reads.
MailboxReader::Found MailboxReader::take_repeat(nanoseconds now, bool touched) {
  switch (fetch_) {
    case Fetch::kRepeatLook:
      if (touched) {
        repeat_bit_ = !is_set(registers_[kActivateOffset - kStatusOffset], wire::SyncManagerActivate::kRepeatRequest);
        registers_[kActivateOffset - kStatusOffset] ^= std::byte{wire::SyncManagerActivate::kRepeatRequest};
        fetch_ = Fetch::kRepeatToggle;
      }
      return Found::kStep;
    case Fetch::kRepeatToggle:
      if (touched) ++repeated_;
      fetch_ = touched ? Fetch::kRepeatWait : Fetch::kRepeatLook;
      repeat_deadline_ = now + kRepeatTimeout;
      return Found::kStep;
    default:
      if (!touched) return Found::kNothing;
      if (is_set(registers_[kPdiControlOffset - kStatusOffset], wire::SyncManagerPdiControl::kRepeatAck) ==
          repeat_bit_) {
        fetch_ = Fetch::kRead;
        return Found::kStep;
      }
      // Some slaves never repeat: the content of their mailbox may be the message whose read was lost before it reached
      // them.
      if (now >= repeat_deadline_ && is_set(registers_[0], wire::SyncManagerStatus::kMailboxFull)) {
        fetch_ = Fetch::kRead;
      }
      return Found::kNothing;
  }
}

}  // namespace driveline::ecat_master
