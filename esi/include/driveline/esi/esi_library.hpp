#pragma once

#include <map>
#include <memory>
#include <utility>

#include "driveline/esi/esi_file.hpp"

namespace driveline::esi {

/// The devices of many ESI files, by their identity. Not thread safe while it is filled.
class EsiLibrary {
 public:
  /// Adds all devices of a file. Of two with one identity the first stays.
  void add(EsiFile file);

  /// The device of this vendor and product: of exactly this revision, else of the highest one below it, since a device
  /// keeps to the descriptions of its older revisions (ETG.2000, RevisionNo); null when there is none.
  [[nodiscard]] std::shared_ptr<const DeviceDescription> find(std::uint32_t vendor, std::uint32_t product,
                                                              std::uint32_t revision) const;
  /// Devices, every revision counted.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

 private:
  using Revisions = std::map<std::uint32_t, std::shared_ptr<const DeviceDescription>>;

  std::map<std::pair<std::uint32_t, std::uint32_t>, Revisions> devices_;
  std::size_t size_ = 0;
};

}  // namespace driveline::esi
