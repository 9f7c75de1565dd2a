#include "driveline/rt/shared_region.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <optional>
#include <utility>

#include "driveline/rt/shared_layout.hpp"

namespace driveline::rt {

namespace {

using shared_detail::kRecordsWord;
using shared_detail::load;
using shared_detail::slot_words;
using shared_detail::store;

using Failure = tl::unexpected<SharedRegionError>;

Failure call_failed(const char* call) {
  return Failure{SharedCallFailed{.call = call, .error_number = errno}};
}

// The header, word by word: the magic; version and form; content and its version; bytes of a record; capacity.
enum HeaderWord : std::size_t { kMagic, kVersionAndForm, kContentAndVersion, kRecordBytes, kCapacity };

constexpr std::uint64_t two(std::uint32_t low, std::uint32_t high) {
  return std::uint64_t{high} << 32 | low;
}

void write_header(std::span<std::uint64_t> words, const SharedLayout& layout) {
  store<std::memory_order_relaxed>(words[kVersionAndForm],
                                   two(kSharedLayoutVersion, static_cast<std::uint32_t>(layout.form)));
  store<std::memory_order_relaxed>(words[kContentAndVersion], two(layout.content, layout.content_version));
  store<std::memory_order_relaxed>(words[kRecordBytes], layout.record_bytes);
  store<std::memory_order_relaxed>(words[kCapacity], layout.capacity);
  store<std::memory_order_release>(words[kMagic], kSharedMagic);
}

/// Reads the header once; an error if it is not one of this library.
tl::expected<SharedLayout, SharedRegionError> read_header(std::span<std::uint64_t> words) {
  const std::uint64_t magic = load<std::memory_order_acquire>(words[kMagic]);
  if (magic != kSharedMagic) {
    return Failure{SharedWrongMagic{.expected = kSharedMagic, .found = magic}};
  }
  const std::uint64_t version_and_form = load<std::memory_order_relaxed>(words[kVersionAndForm]);
  const auto version = static_cast<std::uint32_t>(version_and_form);
  if (version != kSharedLayoutVersion) {
    return Failure{SharedWrongVersion{.expected = kSharedLayoutVersion, .found = version}};
  }
  const std::uint64_t content_and_version = load<std::memory_order_relaxed>(words[kContentAndVersion]);
  return SharedLayout{.form = static_cast<SharedForm>(version_and_form >> 32),
                      .content = static_cast<std::uint32_t>(content_and_version),
                      .content_version = static_cast<std::uint32_t>(content_and_version >> 32),
                      .record_bytes = static_cast<std::uint32_t>(load<std::memory_order_relaxed>(words[kRecordBytes])),
                      .capacity = load<std::memory_order_relaxed>(words[kCapacity])};
}

bool is_capacity(std::uint64_t capacity) {
  return std::has_single_bit(capacity) && capacity <= kMaxSharedBytes;
}

/// Size of a region in bytes, whole pages. With at most 2^30 records of at most 2^32 bytes nothing overflows.
std::uint64_t bytes_of(const SharedLayout& layout) {
  const std::uint64_t words = kRecordsWord + layout.capacity * slot_words(layout.form, layout.record_bytes);
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return (words * sizeof(std::uint64_t) + page - 1) / page * page;
}

unsigned seals_of(SharedForm form) {
  constexpr unsigned kFixedSize = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  return form == SharedForm::kBroadcast ? kFixedSize | F_SEAL_FUTURE_WRITE : kFixedSize;
}

std::optional<SharedRegionError> check_seals(int descriptor, unsigned required) {
  const int seals = ::fcntl(descriptor, F_GET_SEALS);
  if (seals < 0) {
    // EINVAL: a file without seals does not know the request.
    return errno == EINVAL ? SharedRegionError{SharedNotMemory{}} : call_failed("fcntl(F_GET_SEALS)").value();
  }
  const auto present = static_cast<unsigned>(seals);
  if ((present & required) != required) {
    return SharedNotSealed{.required = required, .present = present};
  }
  return std::nullopt;
}

}  // namespace

tl::expected<SharedRegion, SharedRegionError> SharedRegion::create(const std::string& name, SharedLayout layout) {
  const SharedBadCapacity bad{.capacity = layout.capacity, .record_bytes = layout.record_bytes};
  if (layout.capacity == 0 || layout.capacity > kMaxSharedBytes || layout.record_bytes == 0) {
    return Failure{bad};
  }
  layout.capacity = std::bit_ceil(layout.capacity);
  const std::uint64_t bytes = bytes_of(layout);
  if (bytes > kMaxSharedBytes) {
    return Failure{bad};
  }
  const int descriptor = ::memfd_create(name.c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor < 0) {
    return call_failed("memfd_create");
  }
  SharedRegion region{descriptor, layout};
  // Sizes and allocates: a lack of memory is an error here instead of a SIGBUS later.
  if (::fallocate(descriptor, 0, 0, static_cast<off_t>(bytes)) != 0) {
    return call_failed("fallocate");
  }
  if (const auto mapped = region.map(descriptor, true); !mapped) {
    return Failure{mapped.error()};
  }
  write_header(region.words_, layout);
  if (::fcntl(descriptor, F_ADD_SEALS, seals_of(layout.form)) != 0) {
    return call_failed("fcntl(F_ADD_SEALS)");
  }
  return region;
}

tl::expected<SharedRegion, SharedRegionError> SharedRegion::open(int descriptor, const SharedLayout& wanted) {
  // The seals first: size and content then cannot change between check and use.
  if (const auto missing = check_seals(descriptor, seals_of(wanted.form))) {
    return Failure{*missing};
  }
  SharedRegion region{-1, wanted};
  if (const auto mapped = region.map(descriptor, wanted.form == SharedForm::kRing); !mapped) {
    return Failure{mapped.error()};
  }
  const auto found = read_header(region.words_);
  if (!found) {
    return Failure{found.error()};
  }
  if (!is_capacity(found->capacity)) {
    return Failure{SharedBadCapacity{.capacity = found->capacity, .record_bytes = found->record_bytes}};
  }
  if (wanted.capacity == 0) {
    region.layout_.capacity = found->capacity;
  }
  if (*found != region.layout_) {
    return Failure{SharedOtherContent{.expected = region.layout_, .found = *found}};
  }
  if (const std::uint64_t bytes = bytes_of(*found); bytes != region.words_.size_bytes()) {
    return Failure{SharedWrongSize{.expected_bytes = bytes, .found_bytes = region.words_.size_bytes()}};
  }
  return region;
}

tl::expected<void, SharedRegionError> SharedRegion::map(int descriptor, bool writable) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    return call_failed("fstat");
  }
  const auto bytes = static_cast<std::uint64_t>(status.st_size);
  constexpr std::uint64_t kLeast = kRecordsWord * sizeof(std::uint64_t);
  if (bytes < kLeast || bytes > kMaxSharedBytes) {
    return Failure{SharedWrongSize{.expected_bytes = std::clamp(bytes, kLeast, kMaxSharedBytes), .found_bytes = bytes}};
  }
  // Populated: every page is there before the cycle looks at it.
  void* const memory =
      ::mmap(nullptr, bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED | MAP_POPULATE, descriptor, 0);
  if (memory == MAP_FAILED) {
    return call_failed("mmap");
  }
  words_ = {static_cast<std::uint64_t*>(memory), bytes / sizeof(std::uint64_t)};
  return {};
}

SharedRegion::~SharedRegion() {
  release();
}

SharedRegion::SharedRegion(SharedRegion&& other) noexcept
    : descriptor_{std::exchange(other.descriptor_, -1)},
      layout_{other.layout_},
      words_{std::exchange(other.words_, {})} {}

SharedRegion& SharedRegion::operator=(SharedRegion&& other) noexcept {
  if (this != &other) {
    release();
    descriptor_ = std::exchange(other.descriptor_, -1);
    layout_ = other.layout_;
    words_ = std::exchange(other.words_, {});
  }
  return *this;
}

void SharedRegion::release() noexcept {
  if (!words_.empty()) {
    ::munmap(words_.data(), words_.size_bytes());
  }
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

}  // namespace driveline::rt
