#include "driveline/ecat_master/mailbox/mailbox_channel.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace driveline::ecat_master {
namespace {

using std::chrono::nanoseconds;
using Novelty = RepetitionFilter::Novelty;
using Reaction = MailboxDialogue::Reaction;

/// Time limit for the final message of a failed dialogue.
constexpr auto kLeaveTime = std::chrono::milliseconds{100};
/// A request without an answer is sent this often within the time-out of the answer, unless the slave has its own
/// interval.
constexpr int kRequestsPerTimeout = 4;

/// Number of expected messages that always causes a read ahead.
constexpr std::size_t kReadAheadCount = 2;

/// Tells a slave why its message is not processed, in the name of the slave that it addressed.
class Refusal final : public MailboxDialogue {
 public:
  Refusal(wire::MailboxErrorCode code, std::uint16_t source) noexcept
      : MailboxDialogue(wire::MailboxType::kError, 0), source_(source) {
    wire::MailboxErrorReply{code}.encode(service_);
  }

  void begin(std::uint16_t /*position*/, MailboxRoom /*room*/) override {}
  [[nodiscard]] std::uint16_t source() const noexcept override { return source_; }
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return service_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return false; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> /*service*/) override { return Reaction::kForeign; }
  void fail(const Error& /*error*/) override {}

 private:
  std::array<std::byte, wire::MailboxErrorReply::kSize> service_{};
  std::uint16_t source_;
};

/// A message of another slave. If the slave does not take it, only the sender remains without an answer.
class ForwardedMail final : public MailboxDialogue {
 public:
  ForwardedMail(std::uint16_t source, wire::MailboxType type, std::span<const std::byte> service)
      : MailboxDialogue(type, 0), service_(service.begin(), service.end()), source_(source) {}

  void begin(std::uint16_t /*position*/, MailboxRoom /*room*/) override {}
  [[nodiscard]] std::uint16_t source() const noexcept override { return source_; }
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return service_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return false; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> /*service*/) override { return Reaction::kForeign; }
  void fail(const Error& /*error*/) override {}

 private:
  std::vector<std::byte> service_;
  std::uint16_t source_;
};

}  // namespace

MailboxChannel::MailboxChannel(SlaveRef slave, MailboxWindow window, Settings settings)
    : slave_(slave),
      window_(window),
      settings_(settings),
      writer_(slave, window),
      reader_(slave, window, window.timeouts.response.value_or(settings.reply_timeout), settings.idle_poll) {
  settings_.reply_timeout = window.timeouts.response.value_or(settings_.reply_timeout);
}

nanoseconds MailboxChannel::request_timeout() const noexcept {
  return window_.timeouts.request.value_or(settings_.reply_timeout);
}

nanoseconds MailboxChannel::reply_timeout() const noexcept {
  return active_->timeout().value_or(settings_.reply_timeout);
}

MailboxStatistics MailboxChannel::statistics() const noexcept {
  auto statistics = statistics_;
  statistics.repeated = reader_.repeated();
  return statistics;
}

Error MailboxChannel::error(ErrorFacts facts) const noexcept {
  return {facts, slave_.position};
}

void MailboxChannel::submit(std::shared_ptr<MailboxDialogue> dialogue) {
  refusals_.note_request(dialogue->type());
  enqueue(std::move(dialogue));
}

std::optional<wire::MailboxErrorCode> MailboxChannel::send_for(std::uint16_t source, wire::MailboxType type,
                                                               std::span<const std::byte> service) {
  if (service.size() > max_service()) return wire::MailboxErrorCode::kInvalidSize;
  const auto waiting =
      std::count_if(queue_.begin(), queue_.end(), [](const auto& dialogue) { return dialogue->source() != 0; });
  if (static_cast<std::size_t>(waiting) >= kMaxForwarded) return wire::MailboxErrorCode::kNoMoreMemory;
  enqueue(std::make_shared<ForwardedMail>(source, type, service));
  return std::nullopt;
}

void MailboxChannel::enqueue(std::shared_ptr<MailboxDialogue> dialogue) {
  // Insert behind the dialogues of the same and higher priorities.
  const auto place = std::find_if(queue_.begin(), queue_.end(),
                                  [&](const auto& other) { return other->priority() < dialogue->priority(); });
  queue_.insert(place, std::move(dialogue));
}

void MailboxChannel::use_stream(std::shared_ptr<MailboxStream> stream) {
  if (sender_ == Sender::kStream) stop_stream();
  if (stream_) stream_->closed();
  stream_ = std::move(stream);
  if (!stream_) return;
  refusals_.note_request(stream_->type());
  stream_->opened(max_service());
}

/// Stops sending messages of the stream.
void MailboxChannel::stop_stream() noexcept {
  sender_ = Sender::kNone;
  writer_.drop_ahead();
}

/// Stops sending the message of the dialogue.
void MailboxChannel::withdraw() noexcept {
  if (sender_ == Sender::kDialogue) sender_ = Sender::kNone;
  request_.owed = false;
}

void MailboxChannel::finish(Finished& finished) {
  finished.push_back(std::move(active_));
  active_.reset();
  withdraw();
  request_ = {};
}

void MailboxChannel::finish(Finished& finished, const Error& error) {
  if (!request_.leaving) active_->fail(error);
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
  reader_.reset();
}

/// Prepares the new service of the dialogue. Returns false when it does not fit.
bool MailboxChannel::load_outgoing(nanoseconds now) {
  if (active_->outgoing().size() > max_service() || window_.out_length < wire::MailboxHeader::kSize) return false;
  withdraw();
  request_ = {.owed = true, .leaving = request_.leaving, .deadline = now + request_timeout()};
  return true;
}

/// Loads the next message once the slave has taken the previous one: of the dialogue, else of the stream.
void MailboxChannel::load_mail(nanoseconds now) {
  if (sender_ != Sender::kNone) return;
  if (request_.owed) {
    load_request();
    return;
  }
  if (!stream_ || max_service() == 0) return;
  const auto length = stream_->next(writer_.blank());
  if (length == 0) return;
  writer_.seal(stream_->type(), 0, length);
  send_stream(now);
}

/// Puts the message of the dialogue into writer_.
void MailboxChannel::load_request() {
  const auto service = active_->outgoing();
  std::copy(service.begin(), service.end(), writer_.blank().begin());
  const auto seal = request_.again ? &MailboxWriter::seal_again : &MailboxWriter::seal;
  (writer_.*seal)(active_->type(), active_->priority(), service.size(), active_->source());
  request_.counter = writer_.counter();
  sender_ = Sender::kDialogue;
  request_.owed = request_.again = false;
}

nanoseconds MailboxChannel::repeat_interval() const noexcept {
  return window_.timeouts.repeat.value_or(reply_timeout() / kRequestsPerTimeout);
}

/// Whether the slave has taken the request and left it without an answer until now. The mailbox must have been found
/// empty, because an answer in it would belong to the first request.
bool MailboxChannel::repeat_due(nanoseconds now) const noexcept {
  if (!active_ || request_.taken == 0 || sending() || request_.leaving || request_.resume_at || request_.error_reply)
    return false;
  const bool due = repeat_interval().count() > 0 && now >= request_.repeat_at && now < request_.deadline;
  return due && active_->repeatable() && reader_.polled_empty();
}

/// Sends the request again. A slave that is only slow drops a message with the counter of its last one (ETG.1000.4
/// 5.6), so it does not execute the request twice; that holds until the stream has sent another message. A slave that
/// has lost the request may have noted its counter: before the time-out expires, the request gets a new one.
void MailboxChannel::repeat(nanoseconds now) {
  if (!repeat_due(now)) return;
  const bool last = now + repeat_interval() >= request_.deadline;
  request_.repeat_at = now + repeat_interval();
  if (!last && writer_.counter() != request_.counter) return;
  request_.again = !last;
  request_.owed = true;
  ++statistics_.resent;
}

/// The message in writer_ belongs to the stream.
void MailboxChannel::send_stream(nanoseconds now) noexcept {
  sender_ = Sender::kStream;
  stream_times_.deadline = now + request_timeout();
}

void MailboxChannel::start_next(nanoseconds now, Finished& finished) {
  while (!active_ && !queue_.empty()) {
    active_ = std::move(queue_.front());
    queue_.pop_front();
    active_->begin(slave_.position, {max_service(), service_room(window_.in_length)});
    if (load_outgoing(now)) return;
    finish(finished, error(facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(active_->outgoing().size()),
                                                  .limit = window_.out_length}));
  }
}

void MailboxChannel::prepare(nanoseconds now, std::vector<Request>& batch, Finished& finished) {
  start_next(now, finished);
  resume(now, finished);
  repeat(now);
  load_mail(now);
  turn_ = {};
  turn_.wrote = sender_ != Sender::kNone;
  if (turn_.wrote) writer_.append(batch);
  request_.attempted = request_.attempted || sender_ == Sender::kDialogue;
  turn_.fetched = reader_.append(now, active_ != nullptr || now < stream_times_.active_until, batch);
  turn_.reads = turn_.fetched && reader_.reads();
}

void MailboxChannel::prepare_ahead(nanoseconds now, bool alone, std::vector<Request>& batch) {
  ahead_ = {};
  ahead_.ahead = MailboxReader::Ahead::kNothing;
  if (reader_.repeats() || !(turn_.wrote || turn_.fetched)) return;
  if (busy()) {
    const bool asks = turn_.wrote && sender_ == Sender::kDialogue && !request_.leaving && active_->awaits_answer();
    if (asks && alone) read_ahead(kReadAheadCount, batch);
    return;
  }
  if (!stream_) return;
  ahead_.wrote = turn_.wrote ? append_mail_behind(batch) : append_first_mail(now, batch);
  if (ahead_.wrote || now < stream_times_.active_until) read_ahead(expected(alone), batch);
}

void MailboxChannel::read_ahead(std::size_t expected, std::vector<Request>& batch) {
  ahead_.ahead = reader_.append_ahead(turn_.reads, expected, batch);
  ahead_.fetched = ahead_.ahead != MailboxReader::Ahead::kNothing;
  ahead_.reads = ahead_.ahead == MailboxReader::Ahead::kRead;
}

/// Number of messages that justify a read without checking first.
std::size_t MailboxChannel::expected(bool alone) const {
  const bool likely = alone && (!reader_.has_sample() || (turn_.reads && reader_.reads()));
  return likely ? kReadAheadCount : stream_->expected();
}

/// Appends the message of the stream after the one in flight. Returns false when there is none.
bool MailboxChannel::append_mail_behind(std::vector<Request>& batch) {
  if (sender_ != Sender::kStream) return false;
  if (!writer_.has_ahead()) {
    const auto length = stream_->next(writer_.blank_ahead());
    if (length == 0) return false;
    writer_.seal(stream_->type(), 0, length);
  }
  writer_.append_ahead(batch);
  return true;
}

/// Appends a message of the stream when none is in flight. Returns false when there is none.
bool MailboxChannel::append_first_mail(nanoseconds now, std::vector<Request>& batch) {
  if (sender_ != Sender::kNone) return false;
  load_mail(now);
  if (sender_ == Sender::kNone) return false;
  writer_.append(batch);
  return true;
}

bool MailboxChannel::evaluate(nanoseconds now, std::span<const Request> answers, const Outlets& outlets,
                              Finished& finished) {
  const auto turn = std::exchange(turn_, std::exchange(ahead_, {}));
  bool progress = false;
  std::size_t next = 0;
  if (turn.wrote) progress = take_written(now, answers[next++], finished);
  if (turn.fetched) {
    const auto& answer = answers[next];
    const auto found = turn.ahead ? reader_.take_ahead(now, *turn.ahead, answer) : reader_.take(now, answer);
    progress = take_found(now, found, outlets, finished) || progress;
  }
  check_deadlines(now, finished);
  return progress;
}

bool MailboxChannel::take_written(nanoseconds now, const Request& answer, Finished& finished) {
  // Not taken: either the slave has not read the previous message yet, or it has this one already and the answer to the
  // write was lost. In the second case it sees the same counter again and drops the repetition. The stream of the
  // message may have been closed in the meantime.
  if (answer.withheld || answer.working_counter == 0 || sender_ == Sender::kNone) return false;
  ++statistics_.sent;
  const auto sender = std::exchange(sender_, Sender::kNone);
  if (sender == Sender::kStream) {
    stream_->taken();
    if (writer_.advance()) send_stream(now);
    stream_times_.active_until = now + settings_.stream_poll;
    stream_times_.echo_until = now + RefusalRecord::kEchoTime;
    return true;
  }
  // The time-out starts with the first of equal requests.
  if (request_.taken++ == 0) request_.deadline = now + reply_timeout();
  request_.repeat_at = now + repeat_interval();
  if (active_->type() == wire::MailboxType::kError) refusals_.note_sent(now);
  if (request_.leaving || !active_->awaits_answer()) finish(finished);
  return true;
}

bool MailboxChannel::take_found(nanoseconds now, MailboxReader::Found found, const Outlets& outlets,
                                Finished& finished) {
  if (found == MailboxReader::Found::kMail) take_mail(now, outlets, finished);
  if (found == MailboxReader::Found::kSilence) {
    fail_all(error(facts::WorkingCounter{.address = MailboxReader::status_register()}), finished);
  }
  return found == MailboxReader::Found::kMail || found == MailboxReader::Found::kStep;
}

void MailboxChannel::take_mail(nanoseconds now, const Outlets& outlets, Finished& finished) {
  // More messages may follow.
  poll_now();
  const auto header = wire::MailboxHeader::decode(reader_.mail());
  if (!header) {
    ++statistics_.malformed;
    if (active_ && request_.attempted) finish(finished, error(facts::MailboxMalformed{}));
    return;
  }
  const auto mail = reader_.mail().first(wire::MailboxHeader::kSize + header->length);
  const auto [novelty, requested] = repetitions_.take(*header, mail, reader_.repeated());
  const bool repetition = novelty == Novelty::kRepetition;
  // A request that has been sent again may be answered with the same words again.
  const bool believed = repetition && awaits(header->type) && request_.taken > 1 && !requested;
  if (repetition && !believed) {
    ++statistics_.repetitions;
    if (active_ && request_.attempted) ++request_.dropped;
    return;
  }
  ++statistics_.received;
  const auto service = mail.subspan(wire::MailboxHeader::kSize);
  if (forward(now, *header, service, outlets)) return;
  if (header->type == wire::MailboxType::kError) {
    take_error(now, service, finished);
    return;
  }
  const auto reaction = awaits(header->type) ? active_->receive(service) : Reaction::kForeign;
  if (reaction == Reaction::kForeign) {
    if (!repetition) {
      pass_on(now, *header, service, outlets);
    } else {
      ++statistics_.repetitions;
    }
    return;
  }
  if (novelty != Novelty::kNew) {
    ++statistics_.same_counter;
    repetitions_.expect_same_counter();
  }
  react(now, reaction, finished);
}

bool MailboxChannel::awaits(wire::MailboxType type) const noexcept {
  return active_ && request_.attempted && !request_.leaving && type == active_->type();
}

bool MailboxChannel::is_for_another(const wire::MailboxHeader& header) const noexcept {
  return header.address != 0 && header.address != slave_.station;
}

/// Passes on a message whose header addresses another slave (ETG.1000.4 5.6), or refuses it. Returns false when there
/// is no such slave: the address may be wrong and the message the answer to a request of the master.
bool MailboxChannel::forward(nanoseconds now, const wire::MailboxHeader& header, std::span<const std::byte> service,
                             const Outlets& outlets) {
  if (!is_for_another(header)) return false;
  const auto done = outlets.forward(slave_, header, service);
  if (done && !*done) return false;
  if (done) {
    ++statistics_.forwarded;
  } else {
    refuse_request(now, header, done.error());
  }
  return true;
}

/// Handles a message that no dialogue requested.
void MailboxChannel::pass_on(nanoseconds now, const wire::MailboxHeader& header, std::span<const std::byte> service,
                             const Outlets& outlets) {
  const auto type = header.type;
  const bool streamed = stream_ && type == stream_->type();
  if (streamed) {
    stream_times_.active_until = now + settings_.stream_poll;
    reader_.expect_more();
  } else {
    ++statistics_.unclaimed;
  }
  const auto obstacle = outlets.deliver(slave_, type, service);
  if (!obstacle) return;
  if (is_for_another(header)) {
    refuse_request(now, header, wire::MailboxErrorCode::kInvalidHeader);
  } else if (*obstacle != wire::MailboxErrorCode::kUnsupportedProtocol) {
    refuse_request(now, header, *obstacle);
  } else if (!refusals_.has_requested(type)) {
    refuse(type);
  }
}

void MailboxChannel::refuse(wire::MailboxType type) {
  ++statistics_.refused;
  if (!refusals_.refuses_protocol(type)) return;
  submit(std::make_shared<Refusal>(wire::MailboxErrorCode::kUnsupportedProtocol, std::uint16_t{0}));
}

/// Answers a request of the slave that cannot be served or forwarded. An error reply has no answer.
void MailboxChannel::refuse_request(nanoseconds now, const wire::MailboxHeader& header, wire::MailboxErrorCode code) {
  ++statistics_.refused;
  if (header.type == wire::MailboxType::kError || !refusals_.refuses_request(now)) return;
  submit(std::make_shared<Refusal>(code, header.address));
}

/// Continues after the pause that a busy slave requested.
void MailboxChannel::resume(nanoseconds now, Finished& finished) {
  if (!request_.resume_at || now < *request_.resume_at) return;
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
      request_.resume_at = now + active_->pause();
      withdraw();
      request_.deadline = *request_.resume_at + reply_timeout();
      break;
    case Reaction::kAwait:
      withdraw();
      request_.deadline = now + reply_timeout();
      break;
    case Reaction::kDone:
      finish(finished);
      break;
  }
}

/// An error reply states the error, but not the request: it may refer to another protocol. So the expected answer gets
/// a little more time, or its full time when a message of the stream may be meant; if no answer arrives, the error
/// counts.
void MailboxChannel::take_error(nanoseconds now, std::span<const std::byte> service, Finished& finished) {
  const auto reply = wire::MailboxErrorReply::decode(service);
  const bool echo = reply && refusals_.is_echo(now, reply->code);
  if (!active_ || !request_.attempted || request_.leaving || echo) {
    ++statistics_.unclaimed;
    return;
  }
  if (!reply) {
    ++statistics_.malformed;
    finish(finished, error(facts::MailboxMalformed{}));
    return;
  }
  request_.error_reply = static_cast<std::uint16_t>(reply->code);
  if (now >= stream_times_.echo_until) request_.deadline = std::min(request_.deadline, now + settings_.error_grace);
}

/// Also expires while other messages keep arriving: a slave that sends other messages does not answer.
void MailboxChannel::check_deadlines(nanoseconds now, Finished& finished) {
  if (sender_ == Sender::kStream && now >= stream_times_.deadline) {
    stop_stream();
    stream_->given_up();
  }
  if (!active_ || now < request_.deadline) return;
  if (request_.error_reply) {
    finish(finished, error(facts::MailboxError{.code = *request_.error_reply}));
    return;
  }
  if (request_.leaving) {
    finish(finished);
    return;
  }
  ++statistics_.timeouts;
  const bool taken = !sending();
  active_->fail(error(facts::MailboxTimeout{
      .timeout = request_.taken == 0 && !taken ? request_timeout() : reply_timeout(), .dropped = request_.dropped}));
  request_.leaving = true;
  if (taken && active_->takes_leave() && load_outgoing(now)) {
    request_.deadline = now + kLeaveTime;
  } else {
    finish(finished);
  }
}

}  // namespace driveline::ecat_master
