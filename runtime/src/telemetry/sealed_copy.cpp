#include "telemetry/sealed_copy.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace driveline::runtime {

Result<rt::FileDescriptor> sealed_copy(const std::string& content, const std::filesystem::path& file) {
  rt::FileDescriptor copy{::memfd_create("driveline-copy", MFD_CLOEXEC | MFD_ALLOW_SEALING)};
  const bool written =
      copy.valid() && ::write(copy.get(), content.data(), content.size()) == static_cast<ssize_t>(content.size());
  if (!written || ::fcntl(copy.get(), F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_SEAL) != 0) {
    return fail(ErrorKind::kMachine, fmt::format("cannot be copied into memory: {}", std::strerror(errno)),
                file.string());
  }
  return copy;
}

}  // namespace driveline::runtime
