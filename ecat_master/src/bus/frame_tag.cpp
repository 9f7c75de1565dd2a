#include "driveline/ecat_master/bus/frame_tag.hpp"

#include <atomic>
#include <random>

namespace driveline::ecat_master {

std::uint16_t next_frame_instance() {
  static std::atomic<std::uint32_t> next{std::random_device{}()};
  return static_cast<std::uint16_t>(next.fetch_add(1, std::memory_order_relaxed) % FrameTag::kInstances);
}

}  // namespace driveline::ecat_master
