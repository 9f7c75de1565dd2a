#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// The mailboxes of `slave` as its master has configured sync managers 0 and 1; nothing: it has no mailboxes. Requests
/// to them are not sent again (MailboxTimeouts::repeat). Errors: those of the bus.
[[nodiscard]] Outcome<std::optional<ecat_master::MailboxWindow>> read_mailbox_window(ecat_master::Bus& bus,
                                                                                     ecat_master::SlaveRef slave);

/// Whether slaves have mailboxes for CoE in this state.
[[nodiscard]] bool has_mailbox(wire::AlState state) noexcept;

/// Failure, with the slave and the action in `would`: a slave is in OP, so a master drives the line.
[[nodiscard]] Outcome<void> refuse_if_driven(std::span<const ecat_master::AlReport> states, bool force,
                                             std::string_view would);

/// The same for a command that takes the whole line out of operation and claims it; `master` has not scanned yet.
[[nodiscard]] Outcome<void> must_not_be_driven(runtime::Session& session, ecat_master::Master& master, bool force);

}  // namespace driveline::cli
