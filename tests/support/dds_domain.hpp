#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace driveline::test {

/// A private DDS domain outside Linux's ephemeral ports. A locked file reserves it until this process ends, because
/// samples of another test program in the same domain would be counted.
inline std::uint32_t test_domain() {
  static const std::uint32_t kOurs = [] {
    constexpr std::uint32_t kFirst = 10;
    constexpr std::uint32_t kCount = 80;
    for (std::uint32_t i = 0;; ++i) {
      const std::uint32_t domain = kFirst + (static_cast<std::uint32_t>(getpid()) + i) % kCount;
      const std::string lock =
          std::filesystem::temp_directory_path() / ("driveline-test-domain-" + std::to_string(domain));
      const int file = open(lock.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
      if (i >= kCount || (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0)) {
        return domain;
      }
      close(file);
    }
  }();
  return kOurs;
}

}  // namespace driveline::test
