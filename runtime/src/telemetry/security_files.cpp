#include "telemetry/security_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "driveline/runtime/files/input_file.hpp"

namespace driveline::runtime {
namespace {

constexpr const char* kSecurityFiles[] = {"identity_ca.pem",    "certificate.pem", "private_key.pem",
                                          "permissions_ca.pem", "governance.p7s",  "permissions.p7s"};

/// A file in memory with that content, which stays as it is.
Result<port::FileDescriptor> sealed_copy(const std::string& content, const std::filesystem::path& file) {
  port::FileDescriptor copy{::memfd_create("driveline-security", MFD_CLOEXEC | MFD_ALLOW_SEALING)};
  const bool written =
      copy.valid() && ::write(copy.get(), content.data(), content.size()) == static_cast<ssize_t>(content.size());
  if (!written || ::fcntl(copy.get(), F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_SEAL) != 0) {
    return fail(ErrorKind::kMachine, fmt::format("cannot be kept in memory: {}", std::strerror(errno)), file.string());
  }
  return copy;
}

}  // namespace

Result<std::vector<port::FileDescriptor>> open_security_files(const std::filesystem::path& folder) {
  std::vector<port::FileDescriptor> files;
  for (const auto* const name : kSecurityFiles) {
    const auto content = read_input_file(folder / name);
    if (!content) return tl::unexpected(content.error());
    auto copy = sealed_copy(*content, folder / name);
    if (!copy) return tl::unexpected(copy.error());
    files.push_back(std::move(*copy));
  }
  return files;
}

}  // namespace driveline::runtime
