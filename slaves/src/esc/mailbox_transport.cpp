#include "driveline/slaves/esc/mailbox_transport.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::slaves {

using Use = SyncManagerLayout::Use;

namespace {

/// A mailbox message with two bytes of service data, of type 9, which no protocol uses; without counter.
constexpr std::array<std::byte, 8> kForeignMail{std::byte{2}, {}, {}, {}, {}, std::byte{9}, {}, {}};

}  // namespace

MailboxTransport::MailboxTransport(Esc& esc, Device& device) : esc_(esc), device_(device) {
  const auto& layout = device.profile().sync_managers;
  bool has_out = false;
  bool has_in = false;
  for (unsigned n = 0; n < layout.size() && n < esc.sync_managers().count(); ++n) {
    if (layout[n].use == Use::kMailboxOut && !has_out) {
      out_ = n;
      has_out = true;
    } else if (layout[n].use == Use::kMailboxIn && !has_in) {
      in_ = n;
      has_in = true;
    }
  }
  present_ = has_out && has_in;
  std::size_t longest = 0;
  for (const auto* layouts : {&layout, &device.profile().bootstrap_mailboxes}) {
    for (const auto& sync_manager : *layouts) {
      longest = std::max<std::size_t>({longest, sync_manager.max_length, sync_manager.default_length});
    }
  }
  for (auto* buffer : {&scratch_, &last_, &previous_, &waiting_, &held_}) buffer->reserve(longest);
}

void MailboxTransport::reset() noexcept {
  last_.clear();
  previous_.clear();
  waiting_.clear();
  held_.clear();
}

void MailboxTransport::set_fault(Fault fault, std::chrono::nanoseconds delay) noexcept {
  fault_ = fault;
  delay_ = delay;
  release_ = {};
}

void MailboxTransport::run(std::chrono::nanoseconds now) {
  if (!present_) return;
  if (fault_ != Fault::kBusy) accept_request();
  if (esc_.sync_managers().repeat_requested(in_)) repeat_last();
  if (fault_ != Fault::kSilent && send_next(now) && fault_ != Fault::kBusy) accept_request();
}

/// A message that the device does not accept stays in the sync manager.
void MailboxTransport::accept_request() {
  const auto waiting = esc_.sync_managers().waiting_mail(out_);
  if (!waiting.empty() && !device_.takes_mailbox(waiting)) return;
  const auto mail = esc_.sync_managers().take(out_);
  if (!mail.empty()) device_.mailbox_request(mail);
}

void MailboxTransport::repeat_last() {
  auto& unit = esc_.sync_managers();
  if (unit.full(in_)) {
    // A newer message has replaced the missed message: take it back and send it next.
    if (!previous_.empty()) {
      waiting_ = last_;
      last_ = previous_;
      previous_.clear();
      unit.set_deactivated(in_, true);
      unit.set_deactivated(in_, false);
      publish(last_);
    }
  } else if (!last_.empty()) {
    publish(last_);
  }
  unit.acknowledge_repeat(in_);
}

/// Returns true when the device has sent a message.
bool MailboxTransport::send_next(std::chrono::nanoseconds now) {
  auto& unit = esc_.sync_managers();
  if (!unit.operational(in_) || unit.full(in_)) return false;
  if (!waiting_.empty()) {
    scratch_.swap(waiting_);
    waiting_.clear();
  } else if (!held_.empty()) {
    if (now < release_) return false;
    scratch_.swap(held_);
    held_.clear();
  } else {
    if (!fetch(now)) return false;
    if (now < release_) return true;
  }
  if (!publish(scratch_)) return false;
  previous_.swap(last_);
  last_.swap(scratch_);
  return true;
}

/// Fetches the next message of the device and applies the fault. Returns false when there is none.
bool MailboxTransport::fetch(std::chrono::nanoseconds now) {
  const std::size_t length = esc_.sync_managers().channel(in_).length;
  scratch_.resize(length);
  const auto used = std::min(device_.mailbox_reply(scratch_), length);
  if (used == 0) return false;
  scratch_.resize(used);
  spoil();
  if (fault_ == Fault::kLate && delay_.count() > 0) {
    held_ = scratch_;
    release_ = now + delay_;
  } else if (fault_ == Fault::kForeign) {
    held_ = scratch_;
    scratch_.assign(kForeignMail.begin(), kForeignMail.end());
  }
  return true;
}

/// Sets the length in the header according to the fault.
void MailboxTransport::spoil() noexcept {
  if (scratch_.size() < wire::MailboxHeader::kSize) return;
  const auto length = std::span(scratch_).first<2>();
  if (fault_ == Fault::kMalformed) bytes::store_le<std::uint16_t>(length, 3);
  if (fault_ == Fault::kOversized) bytes::store_le<std::uint16_t>(length, 0xFFFF);
}

bool MailboxTransport::publish(std::span<const std::byte> mail) noexcept {
  auto& unit = esc_.sync_managers();
  const auto buffer = unit.begin_publish(in_);
  if (buffer.empty()) return false;
  const auto used = std::min(mail.size(), buffer.size());
  std::memcpy(buffer.data(), mail.data(), used);
  std::fill(buffer.begin() + static_cast<std::ptrdiff_t>(used), buffer.end(), std::byte{0});
  unit.end_publish(in_);
  return true;
}

}  // namespace driveline::slaves
