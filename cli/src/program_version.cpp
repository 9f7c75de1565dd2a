// In a file of its own, because it is recompiled with every commit.

#include "program_version.hpp"

namespace driveline::cli {

std::string_view program_version() noexcept {
  return DRIVELINE_VERSION;
}

std::string_view program_release() noexcept {
  return DRIVELINE_RELEASE;
}

}  // namespace driveline::cli
