#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "failure.hpp"
#include "text/drive_view.hpp"

namespace driveline::cli {

/// Access to the drives of a line for the page of `driveline drive`.
class DriveSource {
 public:
  virtual ~DriveSource() = default;
  DriveSource(const DriveSource&) = delete;
  DriveSource& operator=(const DriveSource&) = delete;

  /// Number of slaves on the line.
  [[nodiscard]] virtual std::size_t size() const noexcept = 0;
  /// Alias addresses of the slaves, by position.
  [[nodiscard]] virtual std::vector<std::uint16_t> aliases() const = 0;
  /// Reads the drive at `position` into `view`. Failure: no mailbox with CoE in its present state, not a drive (1000h),
  /// no answer; `view` then keeps its values and states the reason.
  [[nodiscard]] virtual Outcome<void> read(std::size_t position, DriveView& view) = 0;
  /// Acknowledges the fault of the drive at `position`, which must have been read before: writes 1 to P 153, as the PC
  /// tool does (MSD manual 13.2). Failure: as for read(), or the drive has no such parameter.
  [[nodiscard]] virtual Outcome<void> acknowledge(std::size_t position) = 0;

 protected:
  DriveSource() = default;
};

/// P 153: writing 1 acknowledges a fault.
inline constexpr std::uint16_t kFaultResetIndex = 0x2000 + 153;

/// Checks that the device type (1000h), which must have been read, is that of a servo drive: profile 402.
[[nodiscard]] Outcome<void> check_device_type(std::size_t position, const DriveValues& values);
/// The failure of a drive without P 153.
[[nodiscard]] tl::unexpected<Failure> no_fault_reset(std::size_t position);
/// Whether the error means that the slave can never serve the object, so that it is not read again.
[[nodiscard]] bool never_served(const ecat_master::Error& error) noexcept;

}  // namespace driveline::cli
