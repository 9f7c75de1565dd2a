#include "driveline/rt/shared_region.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <span>
#include <utility>
#include <variant>

#include "driveline/rt/shared_layout.hpp"

namespace driveline::rt {

namespace {

using shared_detail::call_failed;
using shared_detail::store;

using Failure = tl::unexpected<SharedRegionError>;

constexpr std::uint64_t two(std::uint32_t low, std::uint32_t high) {
  return std::uint64_t{high} << 32 | low;
}

void write_header(std::span<std::uint64_t> words, const SharedLayout& layout) {
  using enum shared_detail::HeaderWord;
  store<std::memory_order_relaxed>(words[kVersionAndForm],
                                   two(kSharedLayoutVersion, static_cast<std::uint32_t>(layout.form)));
  store<std::memory_order_relaxed>(words[kContentAndVersion], two(layout.content, layout.content_version));
  store<std::memory_order_relaxed>(words[kRecordBytes], layout.record_bytes);
  store<std::memory_order_relaxed>(words[kCapacity], layout.capacity);
  store<std::memory_order_release>(words[kMagic], kSharedMagic);
}

/// Maps each page for the owner by a write that changes nothing, so that the cycle causes no page fault; a peer may be
/// writing at the same time.
void touch_pages(std::span<std::uint64_t> words) {
  const auto page_words = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) / sizeof(std::uint64_t);
  for (std::size_t at = 0; at < words.size(); at += page_words) {
    std::atomic_ref{words[at]}.fetch_or(0, std::memory_order_relaxed);
  }
}

}  // namespace

tl::expected<SharedRegion, SharedRegionError> SharedRegion::create(const std::string& name, SharedLayout layout,
                                                                   SharedSealing sealing) {
  const SharedBadCapacity bad{.capacity = layout.capacity, .record_bytes = layout.record_bytes};
  if (layout.capacity == 0 || layout.capacity > kMaxSharedBytes || layout.record_bytes == 0) {
    return Failure{bad};
  }
  layout.capacity = std::bit_ceil(layout.capacity);
  const std::uint64_t bytes = shared_detail::bytes_of(layout);
  if (bytes > kMaxSharedBytes) {
    return Failure{bad};
  }
  const int descriptor = ::memfd_create(name.c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor < 0) {
    return Failure{call_failed("memfd_create")};
  }
  SharedRegion region{descriptor, layout};
  // Sets the size and allocates: a lack of memory is an error here instead of a SIGBUS later.
  if (::fallocate(descriptor, 0, 0, static_cast<off_t>(bytes)) != 0) {
    return Failure{call_failed("fallocate")};
  }
  if (const auto failed = region.map(descriptor, true)) {
    return Failure{*failed};
  }
  touch_pages(region.words());
  write_header(region.words(), layout);
  if (::fcntl(descriptor, F_ADD_SEALS, shared_detail::seals_of(layout.form, sealing)) != 0) {
    return Failure{call_failed("fcntl(F_ADD_SEALS)")};
  }
  return region;
}

tl::expected<SharedRegion, SharedRegionError> SharedRegion::open(int descriptor, const SharedLayout& wanted) {
  auto opened = SharedMapping::open(descriptor, wanted);
  if (const auto* error = std::get_if<SharedRegionError>(&opened)) {
    return Failure{*error};
  }
  return SharedRegion{std::move(std::get<SharedMapping>(opened))};
}

tl::expected<void, SharedRegionError> SharedRegion::close_to_writers() {
  if (::fcntl(descriptor_, F_ADD_SEALS, F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0) {
    return Failure{call_failed("fcntl(F_ADD_SEALS)")};
  }
  if (::fallocate(descriptor_, 0, 0, static_cast<off_t>(words().size_bytes())) != 0) {
    return Failure{call_failed("fallocate")};
  }
  // Pages that the peer returned before are mapped again.
  touch_pages(words());
  return {};
}

SharedRegion::~SharedRegion() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

SharedRegion& SharedRegion::operator=(SharedRegion&& other) noexcept {
  if (this != &other) {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
    }
    descriptor_ = std::exchange(other.descriptor_, -1);
    SharedMapping::operator=(std::move(other));
  }
  return *this;
}

}  // namespace driveline::rt
