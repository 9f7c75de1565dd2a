#include "telemetry/security_files.hpp"

#include <string>
#include <utility>

#include "driveline/runtime/files/input_file.hpp"
#include "telemetry/sealed_copy.hpp"

namespace driveline::runtime {
namespace {

constexpr const char* kSecurityFiles[] = {"identity_ca.pem",    "certificate.pem", "private_key.pem",
                                          "permissions_ca.pem", "governance.p7s",  "permissions.p7s"};

}  // namespace

Result<std::vector<rt::FileDescriptor>> open_security_files(const std::filesystem::path& folder) {
  std::vector<rt::FileDescriptor> files;
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
