#pragma once

#include <filesystem>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Opens the six files of DDS Security in `folder`, with the names that scripts/dds-keys.sh uses: identity_ca.pem,
/// certificate.pem, private_key.pem, permissions_ca.pem, governance.p7s, permissions.p7s. Returns unchangeable copies
/// in memory, in this order, because the bridge runs as another user, who may not read the file of the private key.
/// Errors: a file is missing or unreadable (kFile); no memory (kMachine).
[[nodiscard]] Result<std::vector<rt::FileDescriptor>> open_security_files(const std::filesystem::path& folder);

}  // namespace driveline::runtime
