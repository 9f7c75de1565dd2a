#include "support/environment.hpp"

#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>

namespace driveline::bench {
namespace {

constexpr std::string_view compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "gcc " __VERSION__;
#endif
}

}  // namespace

Environment environment() {
  Environment result;
  utsname system{};
  uname(&system);
  result.kernel = system.release;
  result.cpu = "unknown";
  result.cores = std::thread::hardware_concurrency();
  result.compiler = compiler();
  result.commit = DRIVELINE_COMMIT;
  std::ifstream info("/proc/cpuinfo");
  bool named = false;
  for (std::string line; std::getline(info, line);) {
    const auto colon = line.find(": ");
    if (colon == std::string::npos) continue;
    if (!named && line.starts_with("model name")) {
      result.cpu = line.substr(colon + 2);
      named = true;
    }
    if (line.starts_with("flags") && (line + ' ').find(" hypervisor ") != std::string::npos)
      result.virtual_machine = true;
  }
  return result;
}

nlohmann::ordered_json environment_json() {
  const auto where = environment();
  return {{"kernel", where.kernel},     {"cpu", where.cpu},       {"cores", where.cores},
          {"compiler", where.compiler}, {"commit", where.commit}, {"virtual_machine", where.virtual_machine}};
}

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  if (!(statm >> total_pages >> resident_pages)) return 0;
  return resident_pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace driveline::bench
