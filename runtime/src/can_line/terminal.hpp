#pragma once

#include <filesystem>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A pseudo-terminal whose far end other programs open by a link.
class Terminal {
 public:
  /// Makes the terminal and `link` to its far end. A link that an earlier run has left is replaced. Error (kMachine).
  [[nodiscard]] static Result<Terminal> open(const std::filesystem::path& link);
  Terminal(Terminal&& other) noexcept;
  Terminal& operator=(Terminal&& other) noexcept = delete;
  /// Removes the link.
  ~Terminal();

  /// Returns the near end, which does not block.
  [[nodiscard]] int near_end() const noexcept { return near_end_.get(); }

 private:
  Terminal(rt::FileDescriptor near_end, rt::FileDescriptor far_end, std::filesystem::path link);

  rt::FileDescriptor near_end_;
  rt::FileDescriptor far_end_;  ///< kept open: without it the near end reports a hang-up until somebody opens the link
  std::filesystem::path link_;  ///< empty: moved away
};

}  // namespace driveline::runtime
