#include "sdo_transfers.hpp"

namespace driveline::canopen {

std::unique_ptr<SdoTransfer> SdoTransfer::upload(std::uint8_t node, SdoObject object, const SdoOptions& options) {
  if (options.block) return std::make_unique<BlockUpload>(node, object, options);
  return std::make_unique<SegmentedUpload>(node, object, options);
}

std::unique_ptr<SdoTransfer> SdoTransfer::download(std::uint8_t node, SdoObject object, std::span<const std::byte> data,
                                                   const SdoOptions& options) {
  if (options.block) return std::make_unique<BlockDownload>(node, object, data, options);
  return std::make_unique<SegmentedDownload>(node, object, data, options);
}

}  // namespace driveline::canopen
