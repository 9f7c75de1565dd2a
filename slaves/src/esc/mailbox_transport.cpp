#include "driveline/slaves/esc/mailbox_transport.hpp"

#include <algorithm>
#include <cstring>

namespace driveline::slaves {

using Use = SyncManagerLayout::Use;

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
  for (auto* buffer : {&scratch_, &last_, &previous_, &waiting_}) buffer->reserve(longest);
}

void MailboxTransport::reset() noexcept {
  last_.clear();
  previous_.clear();
  waiting_.clear();
}

void MailboxTransport::run() {
  if (!present_) return;
  if (fault_ != Fault::kBusy) accept_request();
  if (esc_.sync_managers().repeat_requested(in_)) repeat_last();
  if (fault_ != Fault::kSilent && send_next() && fault_ != Fault::kBusy) accept_request();
}

/// A mail for which the device has no room stays where it is.
void MailboxTransport::accept_request() {
  const auto waiting = esc_.sync_managers().waiting_mail(out_);
  if (!waiting.empty() && !device_.takes_mailbox(waiting)) return;
  const auto mail = esc_.sync_managers().take(out_);
  if (!mail.empty()) device_.mailbox_request(mail);
}

void MailboxTransport::repeat_last() {
  auto& unit = esc_.sync_managers();
  if (unit.full(in_)) {
    // A newer mail has taken the place of the one the master has missed: it goes back and is sent next.
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

/// True when a mail has left the device.
bool MailboxTransport::send_next() {
  auto& unit = esc_.sync_managers();
  if (!unit.operational(in_) || unit.full(in_)) return false;
  if (waiting_.empty()) {
    const std::size_t length = unit.channel(in_).length;
    scratch_.resize(length);
    const auto used = std::min(device_.mailbox_reply(scratch_), length);
    if (used == 0) return false;
    scratch_.resize(used);
  } else {
    scratch_.swap(waiting_);
    waiting_.clear();
  }
  if (!publish(scratch_)) return false;
  previous_.swap(last_);
  last_.swap(scratch_);
  return true;
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
