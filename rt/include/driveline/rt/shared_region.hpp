#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <variant>

#include "driveline/rt/shared_layout.hpp"

namespace driveline::rt {

/// A call of the system failed.
struct SharedCallFailed {
  const char* call;  ///< e.g. "mmap"
  int error_number;  ///< errno
};

/// The descriptor belongs to a file without seals: a plain file, a pipe.
struct SharedNotMemory {};

/// The memory can still change its size, or its readers can write to it.
struct SharedNotSealed {
  unsigned required;  ///< F_SEAL_... that the form needs
  unsigned present;   ///< F_SEAL_... that are set
};

/// The memory is smaller than a header, or not of the size that follows from its header.
struct SharedWrongSize {
  std::uint64_t expected_bytes;  ///< what it should have, at least
  std::uint64_t found_bytes;     ///< what it has
};

/// The memory does not begin as a region of driveline.
struct SharedWrongMagic {
  std::uint64_t expected;  ///< kSharedMagic
  std::uint64_t found;     ///< the first eight bytes
};

/// The region was made by another version of this library that lays regions out in another way.
struct SharedWrongVersion {
  std::uint32_t expected;  ///< kSharedLayoutVersion
  std::uint32_t found;     ///< of the region
};

/// The region has another layout or content than expected.
struct SharedOtherContent {
  SharedLayout expected;  ///< what was asked for
  SharedLayout found;     ///< what the header says
};

/// No region can be made with so many records of this size.
struct SharedBadCapacity {
  std::uint64_t capacity;      ///< records, as given
  std::uint32_t record_bytes;  ///< of each, as given
};

/// Why there is no shared region.
using SharedRegionError = std::variant<SharedCallFailed, SharedNotMemory, SharedNotSealed, SharedWrongSize,
                                       SharedWrongMagic, SharedWrongVersion, SharedOtherContent, SharedBadCapacity>;

/// The error as one sentence with all of its facts.
[[nodiscard]] std::string describe(const SharedRegionError& error);

/// Every region begins with it ("drvlnshm" in memory).
inline constexpr std::uint64_t kSharedMagic = 0x6D68'736E'6C76'7264;
/// Version of the way in which regions are laid out.
inline constexpr std::uint32_t kSharedLayoutVersion = 1;
/// No region is larger.
inline constexpr std::uint64_t kMaxSharedBytes = std::uint64_t{1} << 30;

/// Memory of fixed size that two processes share: the only way by which data enter or leave the process that runs the
/// cycle.
///
/// The side that owns the cycle creates it (create()) and passes its descriptor to the other by inheritance or
/// SCM_RIGHTS, which maps it with open(). It is a memfd that is sealed against any change of its size, because a peer
/// that truncated it would end the cycle with SIGBUS; a broadcast is sealed against writing by others, too. All of it
/// is allocated and mapped when create() or open() returns, so that the first access does not fault; RealtimeThread
/// locks it with the rest of the process.
///
/// The peer can write every byte of a ring. The header is read once, by open(); the handles (SharedRingWriter,
/// SharedRingReader) keep their own indexes and check the peer's. Seals do not keep a peer with write access from
/// handing pages back to the system (fallocate(2) with FALLOC_FL_PUNCH_HOLE); the next access then costs a page fault
/// and reads zeros.
///
/// Neither create() nor open() is for the cycle.
class SharedRegion {
 public:
  /// Makes a region of `layout`. `name` only appears in /proc. The descriptor is closed on exec.
  [[nodiscard]] static tl::expected<SharedRegion, SharedRegionError> create(const std::string& name,
                                                                            SharedLayout layout);

  /// Maps a region that another process created. `descriptor` remains the caller's and may be closed afterwards. A
  /// broadcast is mapped read-only. A region of another layout than `wanted`, or without its seals, is refused.
  [[nodiscard]] static tl::expected<SharedRegion, SharedRegionError> open(int descriptor, const SharedLayout& wanted);

  /// Unmaps the memory. No handle may use it any more; the memory itself lives as long as another process maps it.
  ~SharedRegion();
  /// The moved-from region may only be destroyed or assigned to. Handles stay valid.
  SharedRegion(SharedRegion&& other) noexcept;
  /// As the constructor; unmaps what this object had mapped.
  SharedRegion& operator=(SharedRegion&& other) noexcept;

  /// Descriptor for the peer; -1 if the region was opened and not created here.
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

  /// Layout as created, or as found and checked by open(), whatever the memory says now. \rtsafe
  [[nodiscard]] const SharedLayout& layout() const noexcept { return layout_; }

  /// All of the memory, header included; for the handles. \rtsafe
  [[nodiscard]] std::span<std::uint64_t> words() const noexcept { return words_; }

 private:
  SharedRegion(int descriptor, const SharedLayout& layout) noexcept : descriptor_{descriptor}, layout_{layout} {}
  [[nodiscard]] tl::expected<void, SharedRegionError> map(int descriptor, bool writable);
  void release() noexcept;

  int descriptor_ = -1;  // ours to close
  SharedLayout layout_;
  std::span<std::uint64_t> words_;
};

}  // namespace driveline::rt
