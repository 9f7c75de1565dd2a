#include "driveline/ecat_master/mailbox_client.hpp"

#include <algorithm>

#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using std::chrono::microseconds;
constexpr auto kPollInterval = microseconds{200};
constexpr unsigned kIn = 1;
/// Register offsets inside a sync manager channel.
constexpr std::uint16_t kStatusOffset = 5;
constexpr std::uint16_t kActivateOffset = 6;
constexpr std::uint16_t kPdiControlOffset = 7;

std::uint16_t channel_register(unsigned channel, std::uint16_t offset) {
  return static_cast<std::uint16_t>(wire::reg::kSyncManager.at(channel) + offset);
}

}  // namespace

Error MailboxClient::error(ErrorKind kind, std::uint32_t code) const noexcept {
  Error e;
  e.kind = kind;
  e.slave = slave_.position;
  e.code = code;
  if (kind == ErrorKind::kMailboxTimeout) {
    e.extra = static_cast<std::uint32_t>(std::chrono::duration_cast<microseconds>(kReplyTimeout).count());
  }
  return e;
}

Result<void> MailboxClient::send(wire::MailboxType type, std::span<const std::byte> service) {
  if (window_.out_length < wire::MailboxHeader::kSize || service.size() > max_service()) {
    Error e = error(ErrorKind::kProcessDataSize);
    e.expected = window_.out_length;
    e.received = static_cast<std::uint32_t>(service.size());
    return tl::unexpected(e);
  }
  counter_ = wire::next_mailbox_counter(counter_);
  // The whole buffer is written: only the access to its last byte hands a mailbox over.
  std::vector<std::byte> mailbox(window_.out_length);
  wire::MailboxHeader header;
  header.length = static_cast<std::uint16_t>(service.size());
  header.type = type;
  header.counter = counter_;
  header.encode(std::span(mailbox).first<wire::MailboxHeader::kSize>());
  std::copy(service.begin(), service.end(), mailbox.begin() + wire::MailboxHeader::kSize);

  const auto deadline = bus_.exchange().now() + kReplyTimeout;
  for (;;) {
    // Not taken: the slave has not read the previous mailbox yet, or it has this one already and the answer to the
    // write was lost. In the second case it sees the same counter again and drops the repetition.
    auto taken = bus_.try_write(slave_, window_.out_address, mailbox);
    if (!taken) return tl::unexpected(taken.error());
    if (*taken) return {};
    if (bus_.exchange().now() >= deadline) return tl::unexpected(error(ErrorKind::kMailboxTimeout));
    bus_.exchange().pause(kPollInterval);
  }
}

/// Reads the mailbox that was full a moment ago. When it is empty now, the reply has been read and lost on the way back
/// and is asked for again, as often as it takes and time allows.
Result<void> MailboxClient::read_full_mailbox(std::span<std::byte> data) {
  const auto deadline = bus_.exchange().now() + kReplyTimeout;
  for (;;) {
    auto taken = bus_.try_read(slave_, window_.in_address, data);
    if (!taken) return tl::unexpected(taken.error());
    if (*taken) return {};
    if (bus_.exchange().now() >= deadline) return tl::unexpected(error(ErrorKind::kMailboxTimeout));
    if (auto done = request_repeat(deadline); !done) return done;
  }
}

/// Toggles the repeat request and waits until the slave has put its last mailbox there again.
Result<void> MailboxClient::request_repeat(std::chrono::nanoseconds deadline) {
  std::array<std::byte, 3> channel{};
  if (auto read = bus_.read(slave_, channel_register(kIn, kStatusOffset), channel); !read) return read;
  const auto activate = channel[kActivateOffset - kStatusOffset] ^ std::byte{wire::SyncManagerActivate::kRepeatRequest};
  if (auto written = bus_.write(slave_, channel_register(kIn, kActivateOffset), {&activate, 1}); !written)
    return written;
  const bool wanted = (activate & std::byte{wire::SyncManagerActivate::kRepeatRequest}) != std::byte{0};
  for (;;) {
    if (auto read = bus_.read(slave_, channel_register(kIn, kStatusOffset), channel); !read) return read;
    const auto pdi_control = channel[kPdiControlOffset - kStatusOffset];
    const bool acknowledged = (pdi_control & std::byte{wire::SyncManagerPdiControl::kRepeatAck}) != std::byte{0};
    if (acknowledged == wanted) return {};
    if (bus_.exchange().now() >= deadline) return tl::unexpected(error(ErrorKind::kMailboxTimeout));
    bus_.exchange().pause(kPollInterval);
  }
}

/// Reads one mailbox when there is a new one. False: none.
Result<bool> MailboxClient::fetch(Mail& mail) {
  std::array<std::byte, 1> status{};
  if (auto read = bus_.read(slave_, channel_register(kIn, kStatusOffset), status); !read) {
    return tl::unexpected(read.error());
  }
  if ((status[0] & std::byte{wire::SyncManagerStatus::kMailboxFull}) == std::byte{0}) return false;
  std::vector<std::byte> data(window_.in_length);
  if (auto read = read_full_mailbox(data); !read) return tl::unexpected(read.error());
  const auto header = wire::MailboxHeader::decode(data);
  if (!header) return tl::unexpected(error(ErrorKind::kMailboxMalformed));
  // A mailbox that has come before carries the same counter again (0 is not counted).
  if (header->counter != 0 && header->counter == last_received_) return false;
  last_received_ = header->counter;
  const auto* begin = data.data() + wire::MailboxHeader::kSize;
  mail = {*header, {begin, begin + header->length}};
  return true;
}

void MailboxClient::collect(const Mail& mail) {
  if (mail.header.type != wire::MailboxType::kCoe) return;
  const auto coe = wire::CoeHeader::decode(mail.service);
  if (!coe || coe->service != wire::CoeService::kEmergency) return;
  const auto emergency = wire::Emergency::decode(std::span(mail.service).subspan(wire::CoeHeader::kSize));
  if (!emergency) return;
  if (emergencies_.size() == kMaxEmergencies) emergencies_.pop_front();
  emergencies_.push_back(*emergency);
}

Result<std::vector<std::byte>> MailboxClient::transact(wire::MailboxType type, std::span<const std::byte> service,
                                                       const IsReply& is_reply) {
  if (auto sent = send(type, service); !sent) return tl::unexpected(sent.error());
  const auto deadline = bus_.exchange().now() + kReplyTimeout;
  for (;;) {
    Mail mail;
    auto fetched = fetch(mail);
    if (!fetched) return tl::unexpected(fetched.error());
    if (*fetched) {
      if (mail.header.type == wire::MailboxType::kError) {
        const auto reply = wire::MailboxErrorReply::decode(mail.service);
        return tl::unexpected(reply ? error(ErrorKind::kMailboxError, static_cast<std::uint32_t>(reply->code))
                                    : error(ErrorKind::kMailboxMalformed));
      }
      if (mail.header.type == type && is_reply(mail.service)) return std::move(mail.service);
      collect(mail);
    }
    // Also while something else keeps arriving: a slave that only chatters does not answer.
    if (bus_.exchange().now() >= deadline) return tl::unexpected(error(ErrorKind::kMailboxTimeout));
    if (!*fetched) bus_.exchange().pause(kPollInterval);
  }
}

Result<void> MailboxClient::poll() {
  for (std::size_t i = 0; i < kMaxEmergencies; ++i) {
    Mail mail;
    auto fetched = fetch(mail);
    if (!fetched) return tl::unexpected(fetched.error());
    if (!*fetched) return {};
    collect(mail);
  }
  return {};
}

std::vector<wire::Emergency> MailboxClient::take_emergencies() {
  std::vector<wire::Emergency> taken(emergencies_.begin(), emergencies_.end());
  emergencies_.clear();
  return taken;
}

}  // namespace driveline::ecat_master
