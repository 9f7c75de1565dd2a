#include "driveline/rt/thread_usage.hpp"

#include <sys/resource.h>

namespace driveline::rt {

ThreadUsage ThreadUsage::now() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);  // fails only on an invalid pointer or selector
  return {usage.ru_minflt, usage.ru_majflt, usage.ru_nvcsw, usage.ru_nivcsw};
}

}  // namespace driveline::rt
