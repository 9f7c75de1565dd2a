#pragma once

#include <filesystem>
#include <vector>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// The six files of DDS Security in `folder`, as scripts/dds-keys.sh names them: identity_ca.pem, certificate.pem,
/// private_key.pem, permissions_ca.pem, governance.p7s, permissions.p7s. Copies in memory, in this order, which nobody
/// can change: the bridge is another user, who may not read the private key where it lies. Errors: one is missing or
/// cannot be read (kFile); no memory (kMachine).
[[nodiscard]] Result<std::vector<port::FileDescriptor>> open_security_files(const std::filesystem::path& folder);

}  // namespace driveline::runtime
