#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"

#include <algorithm>

namespace driveline::ecat_master {

MailboxEngine::~MailboxEngine() {
  MailboxChannel::Finished finished;
  take_submissions(finished);
  for (auto& [position, channel] : channels_) {
    channel.fail_all(Error{facts::Cancelled{}, position}, finished);
    channel.use_stream(nullptr);
  }
  complete(finished);
}

void MailboxEngine::complete(MailboxChannel::Finished& finished) {
  for (const auto& dialogue : finished) dialogue->complete();
  finished.clear();
}

void MailboxEngine::open(SlaveRef slave, MailboxWindow window) {
  close(slave.position);
  const std::scoped_lock lock(step_mutex_);
  auto& channel = channels_.emplace(slave.position, MailboxChannel(slave, window, settings_)).first->second;
  const auto stream = streams_.find(slave.position);
  if (stream != streams_.end()) channel.use_stream(stream->second);
}

void MailboxEngine::close(std::uint16_t position) {
  MailboxChannel::Finished finished;
  {
    const std::scoped_lock lock(step_mutex_);
    take_submissions(finished);
    lose_begun(finished);
    const auto found = channels_.find(position);
    if (found != channels_.end()) {
      found->second.fail_all(Error{facts::Cancelled{}, position}, finished);
      found->second.use_stream(nullptr);
      channels_.erase(found);
    }
  }
  complete(finished);
}

void MailboxEngine::close_all() {
  std::vector<std::uint16_t> open;
  {
    const std::scoped_lock lock(step_mutex_);
    for (const auto& [position, channel] : channels_) open.push_back(position);
  }
  for (const auto position : open) close(position);
}

void MailboxEngine::handle(wire::MailboxType type, MailboxProtocolHandler& handler) {
  const std::scoped_lock lock(step_mutex_);
  handlers_[type] = &handler;
}

void MailboxEngine::open_stream(std::uint16_t position, std::shared_ptr<MailboxStream> stream) {
  const std::scoped_lock lock(step_mutex_);
  streams_[position] = stream;
  use_stream(position, std::move(stream));
}

void MailboxEngine::close_stream(std::uint16_t position) {
  const std::scoped_lock lock(step_mutex_);
  streams_.erase(position);
  use_stream(position, nullptr);
}

/// A message in flight stays in the writer; the next step tells the channel its outcome.
void MailboxEngine::use_stream(std::uint16_t position, std::shared_ptr<MailboxStream> stream) {
  const auto channel = channels_.find(position);
  if (channel != channels_.end()) channel->second.use_stream(std::move(stream));
}

void MailboxEngine::use_status(const MailboxStatusSource* source) {
  const std::scoped_lock lock(step_mutex_);
  status_ = source;
  for (auto& [position, channel] : channels_) channel.use_sample(std::nullopt);
}

void MailboxEngine::submit(std::uint16_t position, std::shared_ptr<MailboxDialogue> dialogue) {
  const std::scoped_lock lock(inbox_mutex_);
  inbox_.push_back({position, std::move(dialogue)});
}

void MailboxEngine::take_submissions(MailboxChannel::Finished& finished) {
  std::vector<Submission> taken;
  {
    const std::scoped_lock lock(inbox_mutex_);
    taken.swap(inbox_);
  }
  for (auto& submission : taken) {
    const auto channel = channels_.find(submission.position);
    if (channel != channels_.end()) {
      channel->second.submit(std::move(submission.dialogue));
      continue;
    }
    submission.dialogue->fail(Error{facts::NoMailbox{submission.dialogue->type()}, submission.position});
    finished.push_back(std::move(submission.dialogue));
  }
}

/// Creates the dialogues of the cycle's requests.
void MailboxEngine::take_requests() {
  const std::scoped_lock lock(inbox_mutex_);
  std::erase_if(requests_, [](const auto& request) { return request.expired(); });
  for (const auto& weak : requests_) {
    const auto request = weak.lock();
    if (request == nullptr) continue;
    if (auto dialogue = request->take()) inbox_.push_back({request->position(), std::move(dialogue)});
  }
}

bool MailboxEngine::step() {
  MailboxChannel::Finished finished;
  bool progress = false;
  {
    const std::unique_lock lock(step_mutex_, std::try_to_lock);
    if (!lock.owns_lock()) return false;
    progress = step_locked(finished);
  }
  progress = progress || !finished.empty();
  complete(finished);
  stepped_.notify_all();
  return progress;
}

bool MailboxEngine::Batch::has(const MailboxChannel& channel) const noexcept {
  return std::any_of(parts.begin(), parts.end(), [&](const Part& part) { return part.channel == &channel; });
}

void MailboxEngine::Batch::note(MailboxChannel& channel, std::size_t first) {
  if (requests.size() > first) parts.push_back({&channel, first, requests.size() - first});
}

bool MailboxEngine::Batch::failed() const noexcept {
  return std::any_of(requests.begin(), requests.end(), [](const Request& request) {
    const bool refused = request.command == wire::Command::kFpwr && request.working_counter == 0;
    return request.withheld || !request.answered || refused;
  });
}

bool MailboxEngine::step_locked(MailboxChannel::Finished& finished) {
  take_requests();
  take_submissions(finished);
  prepare(bus_.exchange().now(), finished);
  if (begun_.parts.empty() && batch_.parts.empty()) return false;
  if (const auto done = bus_.exchange().relay({begun_.requests, batch_.requests, next_.requests}); !done) {
    for (const auto* batch : {&begun_, &batch_}) {
      for (const auto& part : batch->parts) part.channel->fail_all(done.error(), finished);
    }
    begun_.clear();
    return false;
  }
  const bool progress = evaluate(begun_, finished);
  const bool more = evaluate(batch_, finished);
  begun_is_held_ = begun_.failed() || batch_.failed();
  std::swap(begun_, next_);
  return progress || more || !begun_.parts.empty();
}

/// Collects the datagrams that every slave needs now, and the follow-up datagrams for the case that those succeed.
/// Channels whose turn is already in flight need nothing else.
void MailboxEngine::prepare(std::chrono::nanoseconds now, MailboxChannel::Finished& finished) {
  batch_.clear();
  next_.clear();
  // Requests behind an unsent request are not sent either.
  const bool relays = bus_.exchange().relays() && !(begun_is_held_ && !begun_.parts.empty());
  // Judged by the batch of the previous step.
  const bool alone = begun_.parts.size() <= 1;
  for (auto& [position, channel] : channels_) {
    if (status_ != nullptr) channel.use_sample(status_->mailbox_status(position));
    if (!begun_.has(channel)) {
      const auto first = batch_.requests.size();
      channel.prepare(now, batch_.requests, finished);
      batch_.note(channel, first);
    }
    const auto behind = next_.requests.size();
    if (relays) channel.prepare_ahead(now, alone, next_.requests);
    next_.note(channel, behind);
  }
}

bool MailboxEngine::evaluate(const Batch& batch, MailboxChannel::Finished& finished) {
  const auto now = bus_.exchange().now();
  const MailboxChannel::Outlets outlets{
      [this](SlaveRef slave, wire::MailboxType type, std::span<const std::byte> service) {
        return deliver(slave, type, service);
      },
      [this](SlaveRef from, const wire::MailboxHeader& header, std::span<const std::byte> service) {
        return forward(from, header, service);
      }};
  bool progress = false;
  for (const auto& part : batch.parts) {
    const auto answers = std::span<const Request>(batch.requests).subspan(part.first, part.count);
    progress = part.channel->evaluate(now, answers, outlets, finished) || progress;
  }
  return progress;
}

/// The outcome of the begun requests is unknown: treat their frames as lost.
void MailboxEngine::lose_begun(MailboxChannel::Finished& finished) {
  for (auto& request : begun_.requests) {
    request.answered = request.withheld = false;
    request.working_counter = 0;
  }
  evaluate(begun_, finished);
  begun_.clear();
}

std::optional<wire::MailboxErrorCode> MailboxEngine::deliver(SlaveRef slave, wire::MailboxType type,
                                                             std::span<const std::byte> service) {
  const auto handler = handlers_.find(type);
  if (handler == handlers_.end()) return wire::MailboxErrorCode::kUnsupportedProtocol;
  if (handler->second->is_request(service)) return wire::MailboxErrorCode::kServiceNotSupported;
  handler->second->receive(slave, service, bus_.exchange().now());
  return std::nullopt;
}

tl::expected<bool, wire::MailboxErrorCode> MailboxEngine::forward(SlaveRef from, const wire::MailboxHeader& header,
                                                                  std::span<const std::byte> service) {
  const auto to = std::find_if(channels_.begin(), channels_.end(),
                               [&](const auto& channel) { return channel.second.slave().station == header.address; });
  if (to == channels_.end()) return false;
  if (const auto obstacle = to->second.send_for(from.station, header.type, service)) {
    return tl::unexpected(*obstacle);
  }
  return true;
}

void MailboxEngine::pause() {
  bus_.exchange().pause(kPollInterval);
}

void MailboxEngine::drive() {
  if (step()) return;
  std::unique_lock lock(step_mutex_, std::try_to_lock);
  if (lock.owns_lock()) {
    lock.unlock();
    pause();
    return;
  }
  // Another thread steps; it notifies this thread of progress.
  std::unique_lock waiting(wait_mutex_);
  stepped_.wait_for(waiting, kPollInterval);
}

void MailboxEngine::wait(const MailboxDialogue& dialogue) {
  while (!dialogue.done()) drive();
}

Result<void> MailboxEngine::poll(std::uint16_t position) {
  // Listens to a slave that never stops sending for at most the time-out of an answer.
  const auto deadline = bus_.exchange().now() + settings_.reply_timeout;
  {
    const std::scoped_lock lock(step_mutex_);
    const auto channel = channels_.find(position);
    if (channel == channels_.end()) return tl::unexpected(Error{facts::NoMailbox{}, position});
    channel->second.poll_now();
  }
  for (;;) {
    const bool progress = step();
    {
      const std::scoped_lock lock(step_mutex_);
      const auto channel = channels_.find(position);
      if (channel == channels_.end() || channel->second.polled_empty()) return {};
    }
    if (bus_.exchange().now() >= deadline) return {};
    if (!progress) pause();
  }
}

void MailboxEngine::watch(std::weak_ptr<DialogueRequest> request) {
  const std::scoped_lock lock(inbox_mutex_);
  requests_.push_back(std::move(request));
}

MailboxStatistics MailboxEngine::statistics(std::uint16_t position) {
  const std::scoped_lock lock(step_mutex_);
  const auto channel = channels_.find(position);
  return channel == channels_.end() ? MailboxStatistics{} : channel->second.statistics();
}

}  // namespace driveline::ecat_master
