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

/// The right to command an axis, as it is asked for.
struct LeaseTerms {
  std::string owner;  ///< as others are told: "path", "stream", "control socket (process 123, user 1000)"; never empty
  /// The lease ends then unless it is prolonged, on the clock of the callers; none: when it is released.
  std::optional<std::chrono::nanoseconds> until{};
  bool take_over = false;  ///< also from another owner, who is told of it
  bool firm = false;       ///< nobody takes it over: what moves the axes as long as the line runs
};

/// A lease that has ended against the will of its owner.
struct LeaseLoss {
  std::size_t axis = 0;  ///< by its number
  std::string owner;     ///< who had it
  std::string taken_by;  ///< who has it now; empty: it was not prolonged in time
};

/// An axis has changed hands, willingly or not.
struct LeaseChange {
  /// How.
  enum class Kind : std::uint8_t {
    kTaken,      ///< nobody had it
    kTakenOver,  ///< from `before`
    kReleased,   ///< by `before`, and nobody has it now
    kExpired,    ///< the same, because `before` has not prolonged it in time
  };
  std::size_t axis = 0;      ///< by its number
  Kind kind = Kind::kTaken;  ///< how
  std::string owner;         ///< who has it now; empty: nobody
  std::string before;        ///< who had it; empty: nobody
};

/// Why a lease is not to be had.
struct LeaseRefusal {
  std::string owner;  ///< who has it
  bool firm = false;  ///< it cannot be taken over either
};

/// Who may command the axes of a line: path, task, stream, hand. Each axis has at most one owner at a time. A stop asks
/// for no lease: it is allowed to everybody. Owners are the same if their names are.
///
/// Any thread but the cycle's, with a lock inside, except where something else is said.
class AxisAuthority {
 public:
  /// Changes that are kept for take_changes().
  static constexpr std::size_t kMostChanges = 1024;

  /// Nobody commands the axes yet.
  explicit AxisAuthority(std::size_t axes) : leases_(axes), numbers_(axes) {}

  /// Takes the axis, or prolongs the owner's own lease. The number of the lease, which no other has. Error: somebody
  /// else has the axis.
  [[nodiscard]] tl::expected<std::uint64_t, LeaseRefusal> take(std::size_t axis, const LeaseTerms& terms);
  /// Whether take() would give the axis away now, without doing it.
  [[nodiscard]] tl::expected<void, LeaseRefusal> check(std::size_t axis, const LeaseTerms& terms) const;
  /// Gives all leases of `owner` that have an end another one, or none.
  void prolong(std::string_view owner, std::optional<std::chrono::nanoseconds> until);
  /// Gives the axis back; nothing happens if it is another's.
  void release(std::size_t axis, std::string_view owner);
  /// Gives all his axes back: their numbers.
  std::vector<std::size_t> release_all(std::string_view owner);

  /// Ends the leases that were not prolonged in time. All that were lost since the last call, once.
  [[nodiscard]] std::vector<LeaseLoss> losses(std::chrono::nanoseconds now);
  /// How axes have changed hands since the last call, in order; the newest kMostChanges.
  [[nodiscard]] std::vector<LeaseChange> take_changes();
  /// The owner of an axis; empty: nobody.
  [[nodiscard]] std::string owner_of(std::size_t axis) const;
  /// Whether the axis is his.
  [[nodiscard]] bool holds(std::size_t axis, std::string_view owner) const;
  /// Whether the lease of that number goes on; the cycle may ask, too. \rtsafe
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
  std::vector<std::atomic<std::uint64_t>> numbers_;  ///< of the leases; 0: nobody has the axis
  std::uint64_t last_number_ = 0;
  std::vector<LeaseLoss> losses_;
  std::deque<LeaseChange> changes_;
};

}  // namespace driveline::runtime
