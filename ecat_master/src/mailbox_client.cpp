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

Result<bool> MailboxClient::read_full_mailbox(std::span<std::byte> data) {
  auto taken = bus_.try_read(slave_, window_.in_address, data);
  if (!taken || *taken) return taken;
  // It was full a moment ago and is empty now: the reply was read and lost on the way back. Toggle the repeat
  // request and wait until the slave has put it there again.
  std::array<std::byte, 3> channel{};
  auto read = bus_.read(slave_, channel_register(kIn, kStatusOffset), channel);
  if (!read) return tl::unexpected(read.error());
  const auto activate = channel[kActivateOffset - kStatusOffset] ^ std::byte{wire::SyncManagerActivate::kRepeatRequest};
  auto written = bus_.write(slave_, channel_register(kIn, kActivateOffset), {&activate, 1});
  if (!written) return tl::unexpected(written.error());
  const auto deadline = bus_.exchange().now() + kReplyTimeout;
  const bool wanted = (activate & std::byte{wire::SyncManagerActivate::kRepeatRequest}) != std::byte{0};
  for (;;) {
    read = bus_.read(slave_, channel_register(kIn, kStatusOffset), channel);
    if (!read) return tl::unexpected(read.error());
    const auto pdi_control = channel[kPdiControlOffset - kStatusOffset];
    const bool acknowledged = (pdi_control & std::byte{wire::SyncManagerPdiControl::kRepeatAck}) != std::byte{0};
    if (acknowledged == wanted) return bus_.try_read(slave_, window_.in_address, data);
    if (bus_.exchange().now() >= deadline) return tl::unexpected(error(ErrorKind::kMailboxTimeout));
    bus_.exchange().pause(kPollInterval);
  }
}

/// Reads one mailbox when there is one. False: none.
Result<bool> MailboxClient::fetch(Mail& mail) {
  std::array<std::byte, 1> status{};
  if (auto read = bus_.read(slave_, channel_register(kIn, kStatusOffset), status); !read) {
    return tl::unexpected(read.error());
  }
  if ((status[0] & std::byte{wire::SyncManagerStatus::kMailboxFull}) == std::byte{0}) return false;
  std::vector<std::byte> data(window_.in_length);
  auto taken = read_full_mailbox(data);
  if (!taken || !*taken) return taken;
  const auto header = wire::MailboxHeader::decode(data);
  if (!header) return tl::unexpected(error(ErrorKind::kMailboxMalformed));
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
      // A repeated mailbox carries the counter of the one before (0 is not counted).
      const bool repeated = mail.header.counter != 0 && mail.header.counter == last_received_;
      last_received_ = mail.header.counter;
      if (repeated) continue;
      if (mail.header.type == wire::MailboxType::kError) {
        const auto reply = wire::MailboxErrorReply::decode(mail.service);
        return tl::unexpected(reply ? error(ErrorKind::kMailboxError, static_cast<std::uint32_t>(reply->code))
                                    : error(ErrorKind::kMailboxMalformed));
      }
      if (mail.header.type == type && is_reply(mail.service)) return std::move(mail.service);
      collect(mail);
    } else {
      if (bus_.exchange().now() >= deadline) return tl::unexpected(error(ErrorKind::kMailboxTimeout));
      bus_.exchange().pause(kPollInterval);
    }
  }
}

Result<void> MailboxClient::poll() {
  for (std::size_t i = 0; i < kMaxEmergencies; ++i) {
    Mail mail;
    auto fetched = fetch(mail);
    if (!fetched) return tl::unexpected(fetched.error());
    if (!*fetched) return {};
    last_received_ = mail.header.counter;
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
