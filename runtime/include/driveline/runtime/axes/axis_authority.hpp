#pragma once

#include <chrono>
#include <cstddef>
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

/// Why a lease is not to be had.
struct LeaseRefusal {
  std::string owner;  ///< who has it
  bool firm = false;  ///< it cannot be taken over either
};

/// Who may command the axes of a line: path, task, stream, hand. Each axis has at most one owner at a time. A stop asks
/// for no lease: it is allowed to everybody. Owners are the same if their names are.
///
/// Any thread but the cycle's; a lock inside.
class AxisAuthority {
 public:
  /// Nobody commands the axes yet.
  explicit AxisAuthority(std::size_t axes) : leases_(axes) {}

  /// Takes the axis, or prolongs the owner's own lease. Error: somebody else has it.
  [[nodiscard]] tl::expected<void, LeaseRefusal> take(std::size_t axis, const LeaseTerms& terms);
  /// Gives all leases of `owner` that have an end another one, or none.
  void prolong(std::string_view owner, std::optional<std::chrono::nanoseconds> until);
  /// Gives the axis back; nothing happens if it is another's.
  void release(std::size_t axis, std::string_view owner);
  /// Gives all his axes back: their numbers.
  std::vector<std::size_t> release_all(std::string_view owner);

  /// Ends the leases that were not prolonged in time. All that were lost since the last call, once.
  [[nodiscard]] std::vector<LeaseLoss> losses(std::chrono::nanoseconds now);
  /// The owner of an axis; empty: nobody.
  [[nodiscard]] std::string owner_of(std::size_t axis) const;
  /// Whether the axis is his.
  [[nodiscard]] bool holds(std::size_t axis, std::string_view owner) const;

 private:
  struct Lease {
    std::string owner{};
    std::optional<std::chrono::nanoseconds> until{};
    bool firm = false;
  };

  mutable std::mutex lock_;
  std::vector<Lease> leases_;
  std::vector<LeaseLoss> losses_;
};

}  // namespace driveline::runtime
