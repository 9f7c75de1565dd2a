#pragma once

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"

namespace driveline::slaves {

/// Checks the master's mailbox configuration against `layout`; returns kNoError or `error` (ETG.1000.6 Table 11: 0x0015
/// for bootstrap, else 0x0016). A layout without mailboxes always matches. \rtsafe
[[nodiscard]] wire::AlStatusCode check_mailboxes(const Esc& esc, std::span<const SyncManagerLayout> layout,
                                                 wire::AlStatusCode error) noexcept;

/// Checks the process data sync managers against the mapping of the device. Errors: 0x001D (outputs) and 0x001E
/// (inputs) for wrong settings, 0x0029 for mailbox mode, 0x0017 for sync managers that the device does not have and for
/// overlapping areas.
/// \rtsafe
[[nodiscard]] wire::AlStatusCode check_process_data(const Esc& esc, const Device& device) noexcept;

/// Checks that the process data watchdog is usable. Error 0x001F: an output sync manager triggers a watchdog whose time
/// is zero, or shorter than the device's process data period (it would expire in regular operation). \rtsafe
[[nodiscard]] wire::AlStatusCode check_watchdog(const Esc& esc, const Device& device) noexcept;

}  // namespace driveline::slaves
