#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/rt/shared_layout.hpp"
#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_region_error.hpp"

namespace driveline::rt {

/// Memory of fixed size that two processes share: the only path by which data enter or leave the process that runs the
/// cycle.
///
/// The side that owns the cycle creates the region (create()) and passes its descriptor to the other side by
/// inheritance or SCM_RIGHTS. The other side maps it with open(), or with SharedMapping::open() if it does not link
/// this library. The region is a memfd that is sealed against any change of its size, because a peer that truncated it
/// would end the cycle with SIGBUS; a broadcast is also sealed against writing by others. All of it is allocated and
/// mapped when create() or open() returns, so that the first access does not fault; RealtimeThread locks it with the
/// rest of the process.
///
/// Neither create() nor open() is for the cycle.
class SharedRegion : public SharedMapping {
 public:
  /// Creates a region of `layout`. `name` only appears in /proc. The descriptor is closed on exec.
  [[nodiscard]] static tl::expected<SharedRegion, SharedRegionError> create(
      const std::string& name, SharedLayout layout, SharedSealing sealing = SharedSealing::kComplete);

  /// Seals a region of kSizeOnly after its peer has mapped it: mappings that exist can still write, but no process can
  /// map it for writing any more, nor return pages to the system. Then allocates and maps the pages that the peer may
  /// have returned before, so that an access never faults. Error: the peer has sealed the region, or the memory is
  /// exhausted. Not for the cycle.
  [[nodiscard]] tl::expected<void, SharedRegionError> close_to_writers();

  /// Same as SharedMapping::open().
  [[nodiscard]] static tl::expected<SharedRegion, SharedRegionError> open(int descriptor, const SharedLayout& wanted);

  /// Unmaps the memory and closes the descriptor.
  ~SharedRegion();
  /// The moved-from region may only be destroyed or assigned to. Handles stay valid.
  SharedRegion(SharedRegion&& other) noexcept
      : SharedMapping{std::move(other)}, descriptor_{std::exchange(other.descriptor_, -1)} {}
  /// Like the move constructor; first unmaps the memory that this object has mapped.
  SharedRegion& operator=(SharedRegion&& other) noexcept;

  /// Descriptor for the peer; -1 if the region was opened, not created, here.
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

 private:
  SharedRegion(int descriptor, const SharedLayout& layout) noexcept
      : SharedMapping{layout, true}, descriptor_{descriptor} {}
  explicit SharedRegion(SharedMapping mapping) noexcept : SharedMapping{std::move(mapping)} {}

  int descriptor_ = -1;  // owned by this object
};

}  // namespace driveline::rt
