#pragma once

#include <unistd.h>

#include <utility>

namespace driveline::port {

/// Owns a file descriptor and closes it. Holds -1 if there is none.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// Takes over `descriptor`, -1 for none, and closes it in the end.
  explicit FileDescriptor(int descriptor) noexcept : descriptor_{descriptor} {}
  /// Takes over the descriptor of `other`, which then has none.
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);  // the old one is closed with `other`
    return *this;
  }
  ~FileDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  /// The descriptor, -1 when there is none; stays owned. \rtsafe
  [[nodiscard]] int get() const noexcept { return descriptor_; }
  /// Whether there is one. \rtsafe
  [[nodiscard]] bool valid() const noexcept { return descriptor_ >= 0; }
  /// Gives up ownership.
  [[nodiscard]] int release() noexcept { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

}  // namespace driveline::port
