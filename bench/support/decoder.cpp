#include "support/decoder.hpp"

namespace driveline::bench {
namespace {

constexpr std::size_t kBytesPerAxis = 19;

}  // namespace

ecat_master::ProcessImage make_image(std::size_t axes) {
  ecat_master::ProcessDataDemand demand;
  demand.channels = {{true, 2, 0x1100, kBytesPerAxis}, {false, 3, 0x1400, kBytesPerAxis}};
  demand.al_status = true;
  const std::vector<ecat_master::ProcessDataDemand> demands(axes, demand);
  return ecat_master::ProcessImage::lay_out(demands).value();
}

}  // namespace driveline::bench
