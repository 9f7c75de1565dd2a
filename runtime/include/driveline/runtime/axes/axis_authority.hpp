#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::runtime {

/// Terms on which a client requests the right to command an axis.
struct LeaseTerms {
  /// Name shown to others: "path", "stream", "control socket (process 123, user 1000)"; never empty.
  std::string owner;
  /// End of the lease unless it is prolonged, on the clock of the callers; none: it lasts until it is released.
  std::optional<std::chrono::nanoseconds> until{};
  bool take_over = false;  ///< takes the axis even from another owner, which gets a LeaseLoss
  /// For a source that moves the axes throughout the run: cannot be taken over, and neither released nor changed by a
  /// caller of the same name.
  bool firm = false;
};

/// A lease that ended without a release by its owner.
struct LeaseLoss {
  std::size_t axis = 0;  ///< number of the axis
  std::string owner;     ///< previous owner
  std::string taken_by;  ///< new owner; empty: the lease was not prolonged in time
};

/// Change of the owner of an axis, voluntary or not.
struct LeaseChange {
  /// Reason of the change.
  enum class Kind : std::uint8_t {
    kTaken,      ///< the axis had no owner
    kTakenOver,  ///< taken over from `before`
    kReleased,   ///< released by `before`; the axis has no owner now
    kExpired,    ///< not prolonged in time by `before`; the axis has no owner now
  };
  std::size_t axis = 0;      ///< number of the axis
  Kind kind = Kind::kTaken;  ///< reason of the change
  std::string owner;         ///< new owner; empty: none
  std::string before;        ///< previous owner; empty: none
};

/// Why a lease is refused.
struct LeaseRefusal {
  std::string owner;  ///< present owner
  bool firm = false;  ///< the lease cannot be taken over either
};

/// Right to command the axes of a line: by a path, a task, a stream or a client. Each axis has at most one owner at a
/// time. A stop needs no lease: any client may stop an axis. Owners with the same name are the same owner.
///
/// Any thread except the cycle's; uses a lock unless a function says otherwise.
class AxisAuthority {
 public:
  /// Most changes stored for take_changes().
  static constexpr std::size_t kMaxChanges = 1024;

  /// Starts without an owner of any axis.
  explicit AxisAuthority(std::size_t axes) : leases_(axes), numbers_(axes) {}

  /// Takes the axis, or prolongs the lease of `terms.owner`. Returns the number of the lease, which is unique. Error:
  /// another owner has the axis.
  [[nodiscard]] tl::expected<std::uint64_t, LeaseRefusal> take(std::size_t axis, const LeaseTerms& terms);
  /// Checks whether take() would succeed now, without taking the axis.
  [[nodiscard]] tl::expected<void, LeaseRefusal> check(std::size_t axis, const LeaseTerms& terms) const;
  /// Sets the end of all leases of `owner` that have an end; none: they no longer end by time.
  void prolong(std::string_view owner, std::optional<std::chrono::nanoseconds> until);
  /// Releases the axis; does nothing if `owner` does not own it, or owns it by a firm lease.
  void release(std::size_t axis, std::string_view owner);
  /// Releases all axes of `owner` except those with a firm lease. Returns their numbers.
  std::vector<std::size_t> release_all(std::string_view owner);

  /// Ends the leases that were not prolonged in time. Returns all losses since the last call.
  [[nodiscard]] std::vector<LeaseLoss> losses(std::chrono::nanoseconds now);
  /// Returns the changes of owner since the last call, oldest first; at most the newest kMaxChanges.
  [[nodiscard]] std::vector<LeaseChange> take_changes();
  /// Returns the owner of an axis; empty: none.
  [[nodiscard]] std::string owner_of(std::size_t axis) const;
  /// Whether `owner` owns the axis.
  [[nodiscard]] bool holds(std::size_t axis, std::string_view owner) const;
  /// Whether the lease with this number is still valid; the cycle may call it, too. \rtsafe
  [[nodiscard]] bool goes_on(std::size_t axis, std::uint64_t number) const noexcept {
    return number != 0 && numbers_[axis].load(std::memory_order_acquire) == number;
  }

 private:
  struct Lease {
    std::string owner{};
    std::optional<std::chrono::nanoseconds> until{};
    bool firm = false;
  };

  [[nodiscard]] std::optional<LeaseRefusal> obstacle(std::size_t axis, const LeaseTerms& terms) const;
  void end(std::size_t axis, LeaseChange::Kind kind);
  void note(LeaseChange change);

  mutable std::mutex lock_;
  std::vector<Lease> leases_;
  std::vector<std::atomic<std::uint64_t>> numbers_;  ///< number of the lease of each axis; 0: no owner
  std::uint64_t last_number_ = 0;
  std::vector<LeaseLoss> losses_;
  std::deque<LeaseChange> changes_;
};

}  // namespace driveline::runtime
