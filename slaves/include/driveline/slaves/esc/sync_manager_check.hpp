#pragma once

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"

namespace driveline::slaves {

/// Checks the master's mailbox configuration against `layout`: kNoError or `error` (ETG.1000.6 Table 11: 0x0015 for
/// bootstrap, 0x0016 else). A layout without mailboxes fits always. \rtsafe
[[nodiscard]] wire::AlStatusCode check_mailboxes(const Esc& esc, std::span<const SyncManagerLayout> layout,
                                                 wire::AlStatusCode error) noexcept;

/// Checks the process data sync managers against the mapping of the device. Wrong settings are 0x001D (outputs) or
/// 0x001E (inputs), mailbox mode 0x0029, sync managers that the device does not know or areas that overlap 0x0017.
/// \rtsafe
[[nodiscard]] wire::AlStatusCode check_process_data(const Esc& esc, const Device& device) noexcept;

/// Checks that the process data watchdog is usable. An output sync manager that triggers a watchdog whose time is zero,
/// or shorter than the device's process data period (it would expire in regular operation), is 0x001F. \rtsafe
[[nodiscard]] wire::AlStatusCode check_watchdog(const Esc& esc, const Device& device) noexcept;

}  // namespace driveline::slaves
