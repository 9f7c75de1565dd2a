#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "driveline/rt/shared_layout.hpp"
#include "driveline/rt/shared_region_error.hpp"

namespace driveline::rt {

/// First word of every region ("drvlnshm" in memory).
inline constexpr std::uint64_t kSharedMagic = 0x6D68'736E'6C76'7264;
/// Version of the layout of regions.
inline constexpr std::uint32_t kSharedLayoutVersion = 1;
/// Largest size of a region in bytes.
inline constexpr std::uint64_t kMaxSharedBytes = std::uint64_t{1} << 30;

/// Header and seals of a region; for SharedMapping and SharedRegion.
namespace shared_detail {

// Words of the header: magic; version and form; content and its version; bytes per record; capacity.
enum HeaderWord : std::size_t { kMagic, kVersionAndForm, kContentAndVersion, kRecordBytes, kCapacity };

inline SharedRegionError call_failed(const char* call) {
  return SharedCallFailed{.call = call, .error_number = errno};
}

/// Size of a region in bytes, rounded up to whole pages. With at most 2^30 records of at most 2^32 bytes nothing
/// overflows.
inline std::uint64_t bytes_of(const SharedLayout& layout) {
  const std::uint64_t words = kRecordsWord + layout.capacity * slot_words(layout.form, layout.record_bytes);
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return (words * sizeof(std::uint64_t) + page - 1) / page * page;
}

inline unsigned seals_of(SharedForm form, SharedSealing sealing) {
  constexpr unsigned kFixedSize = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  if (sealing == SharedSealing::kSizeOnly) return kFixedSize & ~unsigned{F_SEAL_SEAL};
  return form == SharedForm::kBroadcast ? kFixedSize | F_SEAL_FUTURE_WRITE : kFixedSize;
}

inline std::optional<SharedRegionError> check_seals(int descriptor, unsigned required) {
  const int seals = ::fcntl(descriptor, F_GET_SEALS);
  if (seals < 0) {
    // EINVAL: a file without seals does not support this request.
    return errno == EINVAL ? SharedRegionError{SharedNotMemory{}} : call_failed("fcntl(F_GET_SEALS)");
  }
  const auto present = static_cast<unsigned>(seals);
  if ((present & required) != required) {
    return SharedNotSealed{.required = required, .present = present};
  }
  return std::nullopt;
}

/// Reads the header once; returns an error if it is not a header of this library.
inline std::variant<SharedLayout, SharedRegionError> read_header(std::span<std::uint64_t> words) {
  const std::uint64_t magic = load<std::memory_order_acquire>(words[kMagic]);
  if (magic != kSharedMagic) {
    return SharedRegionError{SharedWrongMagic{.expected = kSharedMagic, .found = magic}};
  }
  const std::uint64_t version_and_form = load<std::memory_order_relaxed>(words[kVersionAndForm]);
  const auto version = static_cast<std::uint32_t>(version_and_form);
  if (version != kSharedLayoutVersion) {
    return SharedRegionError{SharedWrongVersion{.expected = kSharedLayoutVersion, .found = version}};
  }
  const std::uint64_t content_and_version = load<std::memory_order_relaxed>(words[kContentAndVersion]);
  return SharedLayout{.form = static_cast<SharedForm>(version_and_form >> 32),
                      .content = static_cast<std::uint32_t>(content_and_version),
                      .content_version = static_cast<std::uint32_t>(content_and_version >> 32),
                      .record_bytes = static_cast<std::uint32_t>(load<std::memory_order_relaxed>(words[kRecordBytes])),
                      .capacity = load<std::memory_order_relaxed>(words[kCapacity])};
}

}  // namespace shared_detail

/// Memory of fixed size that this process has mapped and shares with another process; the handles (SharedRingWriter,
/// SharedRingReader, SharedBroadcastWriter, SharedBroadcastReader) work on it. Needs only the C++ library and Linux,
/// for programs that take part without linking this library.
///
/// The peer can write every byte of a ring. open() reads the header once; the handles keep their own indexes and check
/// those of the peer. A peer with write access can return pages to the system (fallocate(2) with FALLOC_FL_PUNCH_HOLE);
/// the next access then causes a page fault and reads zeros. SharedRegion::close_to_writers() prevents that.
class SharedMapping {
 public:
  /// Maps a region that another process created (SharedRegion::create()). `descriptor` remains the caller's and may be
  /// closed afterwards. A broadcast is mapped read-only. A region whose layout differs from `wanted`, or whose seals
  /// are missing, is refused. `sealing`: the seals that it must have. Not for the cycle.
  [[nodiscard]] static std::variant<SharedMapping, SharedRegionError> open(
      int descriptor, const SharedLayout& wanted, SharedSealing sealing = SharedSealing::kComplete) {
    // Check the seals first: size and content then cannot change between check and use.
    if (auto missing = shared_detail::check_seals(descriptor, shared_detail::seals_of(wanted.form, sealing))) {
      return *missing;
    }
    SharedMapping mapping{wanted, false};
    if (auto failed = mapping.map(descriptor, wanted.form == SharedForm::kRing)) {
      return *failed;
    }
    if (auto wrong = mapping.accept(wanted)) {
      return *wrong;
    }
    return mapping;
  }

  /// Unmaps the memory. Handles must not use it afterwards; the memory itself lives as long as another process maps it.
  ~SharedMapping() { unmap(); }
  /// The moved-from mapping may only be destroyed or assigned to. Handles stay valid.
  SharedMapping(SharedMapping&& other) noexcept
      : layout_{other.layout_}, words_{std::exchange(other.words_, {})}, made_here_{other.made_here_} {}
  /// Like the move constructor; first unmaps the memory that this object has mapped.
  SharedMapping& operator=(SharedMapping&& other) noexcept {
    if (this != &other) {
      unmap();
      layout_ = other.layout_;
      words_ = std::exchange(other.words_, {});
      made_here_ = other.made_here_;
    }
    return *this;
  }

  /// Layout as created, or as checked by open(), regardless of what the memory contains now. \rtsafe
  [[nodiscard]] const SharedLayout& layout() const noexcept { return layout_; }
  /// The whole memory, header included; for the handles. \rtsafe
  [[nodiscard]] std::span<std::uint64_t> words() const noexcept { return words_; }
  /// Whether this process created the region, and so may write to a broadcast. \rtsafe
  [[nodiscard]] bool made_here() const noexcept { return made_here_; }

 protected:
  /// Constructs a mapping without memory.
  SharedMapping(const SharedLayout& layout, bool made_here) noexcept : layout_{layout}, made_here_{made_here} {}

  /// Maps the memory behind `descriptor`; returns the error if that fails.
  [[nodiscard]] std::optional<SharedRegionError> map(int descriptor, bool writable) {
    struct stat status {};
    if (::fstat(descriptor, &status) != 0) {
      return shared_detail::call_failed("fstat");
    }
    const auto bytes = static_cast<std::uint64_t>(status.st_size);
    constexpr std::uint64_t kLeast = shared_detail::kRecordsWord * sizeof(std::uint64_t);
    if (bytes < kLeast || bytes > kMaxSharedBytes) {
      return SharedWrongSize{.expected_bytes = std::clamp(bytes, kLeast, kMaxSharedBytes), .found_bytes = bytes};
    }
    // MAP_POPULATE: every page is present before the cycle accesses it.
    void* const memory =
        ::mmap(nullptr, bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED | MAP_POPULATE, descriptor, 0);
    if (memory == MAP_FAILED) {
      return shared_detail::call_failed("mmap");
    }
    words_ = {static_cast<std::uint64_t*>(memory), bytes / sizeof(std::uint64_t)};
    return std::nullopt;
  }

 private:
  /// Compares the header with `wanted` and adopts the capacity of the header.
  [[nodiscard]] std::optional<SharedRegionError> accept(const SharedLayout& wanted) {
    const auto header = shared_detail::read_header(words_);
    if (const auto* wrong = std::get_if<SharedRegionError>(&header)) {
      return *wrong;
    }
    const auto& found = *std::get_if<SharedLayout>(&header);
    if (!std::has_single_bit(found.capacity) || found.capacity > kMaxSharedBytes) {
      return SharedBadCapacity{.capacity = found.capacity, .record_bytes = found.record_bytes};
    }
    if (wanted.capacity == 0) {
      layout_.capacity = found.capacity;
    }
    if (found != layout_) {
      return SharedOtherContent{.expected = layout_, .found = found};
    }
    if (const std::uint64_t bytes = shared_detail::bytes_of(found); bytes != words_.size_bytes()) {
      return SharedWrongSize{.expected_bytes = bytes, .found_bytes = words_.size_bytes()};
    }
    return std::nullopt;
  }

  void unmap() noexcept {
    if (!words_.empty()) {
      ::munmap(words_.data(), words_.size_bytes());
    }
  }

  SharedLayout layout_;
  std::span<std::uint64_t> words_;
  bool made_here_;
};

}  // namespace driveline::rt
