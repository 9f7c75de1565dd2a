#include "driveline/rt/cpu_latency.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>

namespace driveline::rt {

namespace {

constexpr const char* kLatencyName = "CPU wake-up time";

std::string at_most(std::int64_t us) {
  return "at most " + std::to_string(us) + " us";
}

std::string latency_remedy(int error_number, const std::string& device) {
  if (error_number == ENOENT || error_number == ENODEV || error_number == ENXIO) {
    return "none where the kernel has no " + device + "; pass it to a container (`--device " + device + "`)";
  }
  return "run as root, or let a group open " + device +
         R"( (udev: KERNEL=="cpu_dma_latency", GROUP="realtime", MODE="0660"))";
}

}  // namespace

CpuLatencyHold::~CpuLatencyHold() {
  release();
}

RealtimeItem CpuLatencyHold::request(std::chrono::microseconds limit, const std::string& device) {
  release();
  // The kernel takes and returns 32 bits in native byte order.
  const auto wanted_us =
      static_cast<std::int32_t>(std::clamp<std::int64_t>(limit.count(), 0, std::numeric_limits<std::int32_t>::max()));
  RealtimeItem item{.name = kLatencyName, .requested = at_most(wanted_us), .effective = {}, .remedy = {}};
  std::int32_t effective_us = -1;
  constexpr ssize_t kBytes = sizeof wanted_us;
  errno = 0;
  descriptor_ = open(device.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor_ < 0 || write(descriptor_, &wanted_us, kBytes) != kBytes ||
      pread(descriptor_, &effective_us, kBytes, 0) != kBytes) {
    item.error_number = errno;
  }
  item.ok = item.error_number == 0 && effective_us >= 0 && effective_us <= wanted_us;
  item.effective = effective_us >= 0 ? at_most(effective_us) : "left to the kernel";
  if (!item.ok) {
    item.remedy = latency_remedy(item.error_number, device);
    release();
  }
  return item;
}

void CpuLatencyHold::release() noexcept {
  if (descriptor_ >= 0) {
    close(descriptor_);
    descriptor_ = -1;
  }
}

RealtimeItem CpuLatencyHold::not_requested() {
  return {.name = kLatencyName, .requested = "not requested", .effective = "left to the kernel", .remedy = {}};
}

}  // namespace driveline::rt
