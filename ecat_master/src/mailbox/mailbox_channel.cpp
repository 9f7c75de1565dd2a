#include "driveline/ecat_master/mailbox/mailbox_channel.hpp"

#include <algorithm>
#include <array>

#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using std::chrono::nanoseconds;
using Reaction = MailboxDialogue::Reaction;

/// Register offsets inside a sync manager channel.
constexpr std::uint16_t kStatusOffset = 5;
constexpr std::uint16_t kActivateOffset = 6;
constexpr std::uint16_t kPdiControlOffset = 7;
constexpr unsigned kIn = 1;
/// Polls in a row that a slave may leave unanswered before it counts as gone: a port that opens or closes costs one.
constexpr unsigned kSilentPolls = 3;
/// Time for the last word of a dialogue that has failed.
constexpr auto kLeaveTime = std::chrono::milliseconds{100};
/// Slaves that answer an error reply with an error reply do so within this time.
constexpr auto kEchoTime = std::chrono::milliseconds{20};

constexpr std::uint16_t bit_of(wire::MailboxType type) {
  return static_cast<std::uint16_t>(1U << (static_cast<unsigned>(type) & 0x0FU));
}

/// Tells a slave that nobody here knows the protocol of its mail.
class Refusal final : public MailboxDialogue {
 public:
  Refusal() noexcept : MailboxDialogue(wire::MailboxType::kError, 0) {
    wire::MailboxErrorReply{wire::MailboxErrorCode::kUnsupportedProtocol}.encode(service_);
  }

  void begin(std::uint16_t /*position*/, MailboxRoom /*room*/) override {}
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return service_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return false; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> /*service*/) override { return Reaction::kForeign; }
  void fail(const Error& /*error*/) override {}

 private:
  std::array<std::byte, wire::MailboxErrorReply::kSize> service_{};
};

std::uint16_t in_register(std::uint16_t offset) {
  return static_cast<std::uint16_t>(wire::reg::kSyncManager.at(kIn) + offset);
}

bool is_set(std::byte value, std::uint8_t bits) {
  return (value & std::byte{bits}) != std::byte{0};
}

}  // namespace

MailboxChannel::MailboxChannel(SlaveRef slave, MailboxWindow window, Settings settings)
    : slave_(slave), window_(window), settings_(settings), in_wire_(window.in_length) {
  settings_.reply_timeout = window.timeouts.response.value_or(settings_.reply_timeout);
  counter_ = window.last_counter;
}

nanoseconds MailboxChannel::request_timeout() const noexcept {
  return window_.timeouts.request.value_or(settings_.reply_timeout);
}

nanoseconds MailboxChannel::reply_timeout() const noexcept {
  return active_->patience().value_or(settings_.reply_timeout);
}

std::size_t MailboxChannel::max_service() const noexcept {
  return window_.out_length < wire::MailboxHeader::kSize ? 0 : window_.out_length - wire::MailboxHeader::kSize;
}

Error MailboxChannel::error(ErrorFacts facts) const noexcept {
  return {facts, slave_.position};
}

void MailboxChannel::submit(std::shared_ptr<MailboxDialogue> dialogue) {
  known_ |= bit_of(dialogue->type());
  // Behind those of its own and higher priorities.
  const auto place = std::find_if(queue_.begin(), queue_.end(),
                                  [&](const auto& other) { return other->priority() < dialogue->priority(); });
  queue_.insert(place, std::move(dialogue));
}

void MailboxChannel::finish(Finished& finished) {
  finished.push_back(std::move(active_));
  active_.reset();
  sending_ = attempted_ = leaving_ = false;
  resume_at_.reset();
  error_reply_.reset();
}

void MailboxChannel::finish(Finished& finished, const Error& error) {
  if (!leaving_) active_->fail(error);
  finish(finished);
}

void MailboxChannel::fail_all(Error error, Finished& finished) {
  error.slave = slave_.position;
  if (active_) finish(finished, error);
  for (auto& waiting : queue_) {
    waiting->fail(error);
    finished.push_back(std::move(waiting));
  }
  queue_.clear();
  fetch_ = Fetch::kPoll;
}

/// Puts the dialogue's next service into a mailbox with a new counter. False: it does not fit.
bool MailboxChannel::load_outgoing(nanoseconds now) {
  const auto service = active_->outgoing();
  if (service.size() > max_service() || window_.out_length < wire::MailboxHeader::kSize) return false;
  counter_ = wire::next_mailbox_counter(counter_);
  // The whole buffer is written: only the access to its last byte hands a mailbox over.
  outgoing_.assign(window_.out_length, std::byte{0});
  wire::MailboxHeader header;
  header.length = static_cast<std::uint16_t>(service.size());
  header.priority = active_->priority();
  header.type = active_->type();
  header.counter = counter_;
  header.encode(std::span(outgoing_).first<wire::MailboxHeader::kSize>());
  std::copy(service.begin(), service.end(), outgoing_.begin() + wire::MailboxHeader::kSize);
  sending_ = true;
  attempted_ = false;
  resume_at_.reset();
  error_reply_.reset();
  deadline_ = now + request_timeout();
  return true;
}

void MailboxChannel::start_next(nanoseconds now, Finished& finished) {
  while (!active_ && !queue_.empty()) {
    active_ = std::move(queue_.front());
    queue_.pop_front();
    const auto in = std::max<std::size_t>(window_.in_length, wire::MailboxHeader::kSize) - wire::MailboxHeader::kSize;
    active_->begin(slave_.position, {max_service(), in});
    if (load_outgoing(now)) return;
    finish(finished, error(facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(active_->outgoing().size()),
                                                  .limit = window_.out_length}));
  }
}

void MailboxChannel::use_sample(std::optional<MailboxStatusSample> sample) noexcept {
  sample_ = sample;
  if (!sample_ || !sample_is_old_) return;
  // The frame of the cycle that runs now may have passed the slave before the mailbox was read; the next one has not.
  sample_from_ = sample_->cycle + 2;
  sample_is_old_ = false;
}

/// True: the next datagram is about the mailbox. With a sample that is none but the read of a full mailbox.
bool MailboxChannel::wants_poll(nanoseconds now) noexcept {
  if (!sample_) return active_ != nullptr || now >= next_idle_poll_;
  if (sample_->cycle < sample_from_) return false;
  if (sample_->full) {
    fetch_ = Fetch::kRead;
    repeat_deadline_ = now + settings_.reply_timeout;
    return true;
  }
  next_idle_poll_ = now + settings_.idle_poll;
  return false;
}

void MailboxChannel::prepare(nanoseconds now, std::vector<Request>& batch, Finished& finished) {
  start_next(now, finished);
  resume(now, finished);
  wrote_ = sending_;
  if (wrote_) {
    out_wire_ = outgoing_;
    batch.push_back({wire::Command::kFpwr, wire::DatagramAddress::physical(slave_.station, window_.out_address),
                     out_wire_, 0, false});
    attempted_ = true;
  }
  fetched_ = fetch_ != Fetch::kPoll || wants_poll(now);
  if (!fetched_) return;
  auto access = [&](wire::Command command, std::uint16_t address, std::span<std::byte> data) {
    batch.push_back({command, wire::DatagramAddress::physical(slave_.station, address), data, 0, false});
  };
  switch (fetch_) {
    case Fetch::kPoll:
      access(wire::Command::kFprd, in_register(kStatusOffset), std::span(registers_).first(1));
      break;
    case Fetch::kRead:
      access(wire::Command::kFprd, window_.in_address, in_wire_);
      break;
    case Fetch::kRepeatLook:
    case Fetch::kRepeatWait:
      access(wire::Command::kFprd, in_register(kStatusOffset), registers_);
      break;
    case Fetch::kRepeatToggle:
      access(wire::Command::kFpwr, in_register(kActivateOffset), std::span(registers_).subspan(1, 1));
      break;
  }
}

bool MailboxChannel::evaluate(nanoseconds now, std::span<const Request> answers, const Deliver& deliver,
                              Finished& finished) {
  bool progress = false;
  std::size_t next = 0;
  if (wrote_) progress = take_written(now, answers[next++], finished);
  if (fetched_) progress = take_fetched(now, answers[next], deliver, finished) || progress;
  look_at_clock(now, finished);
  return progress;
}

bool MailboxChannel::take_written(nanoseconds now, const Request& answer, Finished& finished) {
  // Not taken: the slave has not read the previous mailbox yet, or it has this one already and the answer to the write
  // was lost. In the second case it sees the same counter again and drops the repetition.
  if (answer.working_counter == 0) return false;
  sending_ = false;
  ++statistics_.sent;
  deadline_ = now + reply_timeout();
  if (active_->type() == wire::MailboxType::kError) echo_until_ = now + kEchoTime;
  if (leaving_ || !active_->awaits_answer()) finish(finished);
  return true;
}

/// Moves on with fetching: poll; read; when a full mailbox turns out to be empty, its content has been read and lost on
/// the way back, and the slave is asked for it again: toggle the repeat request, wait for the acknowledge, read.
bool MailboxChannel::take_fetched(nanoseconds now, const Request& answer, const Deliver& deliver, Finished& finished) {
  const bool touched = answer.working_counter != 0;
  switch (fetch_) {
    case Fetch::kPoll: {
      next_idle_poll_ = now + settings_.idle_poll;
      if (!touched) {
        if (++silent_ < kSilentPolls) return false;
        fail_all(error(facts::WorkingCounter{.address = in_register(kStatusOffset)}), finished);
        return false;
      }
      silent_ = 0;
      if (!is_set(registers_[0], wire::SyncManagerStatus::kMailboxFull)) return false;
      fetch_ = Fetch::kRead;
      repeat_deadline_ = now + settings_.reply_timeout;
      return true;
    }
    case Fetch::kRead:
      fetch_ = touched ? Fetch::kPoll : Fetch::kRepeatLook;
      if (touched) take_mail(now, deliver, finished);
      break;
    case Fetch::kRepeatLook:
      if (touched) {
        repeat_bit_ = !is_set(registers_[kActivateOffset - kStatusOffset], wire::SyncManagerActivate::kRepeatRequest);
        registers_[kActivateOffset - kStatusOffset] ^= std::byte{wire::SyncManagerActivate::kRepeatRequest};
        fetch_ = Fetch::kRepeatToggle;
      }
      break;
    case Fetch::kRepeatToggle:
      if (touched) ++statistics_.repeated;
      fetch_ = touched ? Fetch::kRepeatWait : Fetch::kRepeatLook;
      break;
    case Fetch::kRepeatWait:
      if (touched && is_set(registers_[kPdiControlOffset - kStatusOffset], wire::SyncManagerPdiControl::kRepeatAck) ==
                         repeat_bit_) {
        fetch_ = Fetch::kRead;
        return true;
      }
      if (now >= repeat_deadline_) fetch_ = Fetch::kPoll;
      return false;
  }
  // A slave that never lets itself be read does not hold the channel for ever.
  if (fetch_ != Fetch::kPoll && now >= repeat_deadline_) fetch_ = Fetch::kPoll;
  return true;
}

void MailboxChannel::take_mail(nanoseconds now, const Deliver& deliver, Finished& finished) {
  // More may be waiting behind it.
  poll_now();
  const auto header = wire::MailboxHeader::decode(in_wire_);
  if (!header) {
    ++statistics_.malformed;
    if (active_ && attempted_) finish(finished, error(facts::MailboxMalformed{}));
    return;
  }
  // A mailbox that has come before carries the same counter again (0 is not counted).
  if (header->counter != 0 && header->counter == last_received_) return;
  last_received_ = header->counter;
  ++statistics_.received;
  const auto service = std::span<const std::byte>(in_wire_).subspan(wire::MailboxHeader::kSize, header->length);
  if (header->type == wire::MailboxType::kError) {
    take_error(now, service, finished);
    return;
  }
  const bool mine = active_ && attempted_ && !leaving_ && header->type == active_->type();
  const auto reaction = mine ? active_->receive(service) : Reaction::kForeign;
  if (reaction == Reaction::kForeign) {
    ++statistics_.unclaimed;
    if (!deliver(slave_, header->type, service) && (known_ & bit_of(header->type)) == 0) refuse(header->type);
    return;
  }
  react(now, reaction, finished);
}

/// Each protocol once: a slave that goes on has not understood.
void MailboxChannel::refuse(wire::MailboxType type) {
  ++statistics_.refused;
  if ((refused_ & bit_of(type)) != 0) return;
  refused_ |= bit_of(type);
  submit(std::make_shared<Refusal>());
}

/// The time is over for which a slave asked to be left alone.
void MailboxChannel::resume(nanoseconds now, Finished& finished) {
  if (!resume_at_ || now < *resume_at_) return;
  if (!load_outgoing(now)) finish(finished, error(facts::MailboxMalformed{}));
}

void MailboxChannel::react(nanoseconds now, Reaction reaction, Finished& finished) {
  switch (reaction) {
    case Reaction::kForeign:
      break;
    case Reaction::kSend:
      if (!load_outgoing(now)) finish(finished, error(facts::MailboxMalformed{}));
      break;
    case Reaction::kPause:
      resume_at_ = now + active_->pause();
      sending_ = false;
      deadline_ = *resume_at_ + reply_timeout();
      break;
    case Reaction::kAwait:
      sending_ = false;
      deadline_ = now + reply_timeout();
      break;
    case Reaction::kDone:
      finish(finished);
      break;
  }
}

/// An error reply tells what is wrong, but not with which request: it may be about another protocol. What is awaited
/// gets a little more time; the error counts when nothing comes.
void MailboxChannel::take_error(nanoseconds now, std::span<const std::byte> service, Finished& finished) {
  const auto reply = wire::MailboxErrorReply::decode(service);
  const bool echo = now < echo_until_ && reply && reply->code == wire::MailboxErrorCode::kUnsupportedProtocol;
  if (!active_ || !attempted_ || leaving_ || echo) {
    ++statistics_.unclaimed;
    return;
  }
  if (!reply) {
    ++statistics_.malformed;
    finish(finished, error(facts::MailboxMalformed{}));
    return;
  }
  error_reply_ = static_cast<std::uint16_t>(reply->code);
  deadline_ = std::min(deadline_, now + settings_.error_grace);
}

/// Also while something else keeps arriving: a slave that only chatters does not answer.
void MailboxChannel::look_at_clock(nanoseconds now, Finished& finished) {
  if (!active_ || now < deadline_) return;
  if (error_reply_) {
    finish(finished, error(facts::MailboxError{.code = *error_reply_}));
    return;
  }
  if (leaving_) {
    finish(finished);
    return;
  }
  ++statistics_.timeouts;
  const bool taken = !sending_;
  active_->fail(error(facts::MailboxTimeout{.timeout = sending_ ? request_timeout() : reply_timeout()}));
  leaving_ = true;
  if (taken && active_->takes_leave() && load_outgoing(now)) {
    deadline_ = now + kLeaveTime;
  } else {
    finish(finished);
  }
}

}  // namespace driveline::ecat_master
