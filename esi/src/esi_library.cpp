#include "driveline/esi/esi_library.hpp"

namespace driveline::esi {

void EsiLibrary::add(EsiFile file) {
  for (auto& device : file.devices) {
    auto& revisions = devices_[{device.vendor_id, device.product_code}];
    const auto revision = device.revision;
    if (revisions.count(revision) != 0) continue;
    revisions.emplace(revision, std::make_shared<const DeviceDescription>(std::move(device)));
    ++size_;
  }
}

std::shared_ptr<const DeviceDescription> EsiLibrary::find(std::uint32_t vendor, std::uint32_t product,
                                                          std::uint32_t revision) const {
  const auto known = devices_.find({vendor, product});
  if (known == devices_.end()) return nullptr;
  const auto above = known->second.upper_bound(revision);
  return above == known->second.begin() ? nullptr : std::prev(above)->second;
}

}  // namespace driveline::esi
