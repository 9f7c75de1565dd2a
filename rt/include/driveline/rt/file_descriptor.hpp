#pragma once

#include <unistd.h>

#include <utility>

namespace driveline::rt {

/// Owns a file descriptor and closes it. Holds -1 when it owns none.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// Takes over `descriptor` (-1: none) and closes it on destruction.
  explicit FileDescriptor(int descriptor) noexcept : descriptor_{descriptor} {}
  /// Takes over the descriptor of `other`, which then owns none.
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);  // the old one is closed with `other`
    return *this;
  }
  ~FileDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  /// The descriptor, -1 when there is none; it stays owned by this object. \rtsafe
  [[nodiscard]] int get() const noexcept { return descriptor_; }
  /// Whether this object owns a descriptor. \rtsafe
  [[nodiscard]] bool valid() const noexcept { return descriptor_ >= 0; }
  /// Returns the descriptor and gives up its ownership.
  [[nodiscard]] int release() noexcept { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

}  // namespace driveline::rt
