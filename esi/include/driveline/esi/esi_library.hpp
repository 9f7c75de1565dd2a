#pragma once

#include <map>
#include <memory>
#include <utility>

#include "driveline/esi/esi_file.hpp"

namespace driveline::esi {

/// Devices of several ESI files, indexed by identity. Not thread safe while files are added.
class EsiLibrary {
 public:
  /// Adds all devices of a file. A device whose identity is already present is ignored.
  void add(EsiFile file);

  /// Returns the device of this vendor and product in exactly this revision, or else in the highest lower revision,
  /// since a device conforms to the descriptions of its older revisions (ETG.2000, RevisionNo); null when there is
  /// none.
  [[nodiscard]] std::shared_ptr<const DeviceDescription> find(std::uint32_t vendor, std::uint32_t product,
                                                              std::uint32_t revision) const;
  /// Returns the number of devices; every revision counts.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

 private:
  using Revisions = std::map<std::uint32_t, std::shared_ptr<const DeviceDescription>>;

  std::map<std::pair<std::uint32_t, std::uint32_t>, Revisions> devices_;
  std::size_t size_ = 0;
};

}  // namespace driveline::esi
