// ESI files named by a line description: read by the program, simulated, and used by the master for the configuration.

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "fuzz_lines.hpp"
#include "fuzz_seeds.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

constexpr std::size_t kMaxDevices = 8;

/// A file in memory.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::byte> content) : file_(memfd_create("input.xml", MFD_CLOEXEC)) {
    while (file_ >= 0 && !content.empty()) {
      const auto written = ::write(file_, content.data(), content.size());
      if (written <= 0) std::abort();
      content = content.subspan(static_cast<std::size_t>(written));
    }
    if (file_ < 0) std::abort();
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

/// A line of this device. A script sets its first input; an invalid text is refused.
std::string line_of(const esi::DeviceDescription& device, const std::string& file) {
  std::string text = "[line]\ncycle_us = 1000\n[bus]\nesi = [\"" + file + "\"]\n[[slave]]\nname = \"x\"\nesi = \"" +
                     file + "\"\nproduct_code = " + std::to_string(device.product_code) +
                     "\nrevision = " + std::to_string(device.revision) + "\n";
  for (const auto& pdo : device.tx_pdos) {
    for (const auto& entry : pdo.entries) {
      if (entry.index == 0) continue;
      const auto hex = [](unsigned value) {
        char digits[8];
        std::snprintf(digits, sizeof digits, "%x", value);
        return std::string(digits);
      };
      return text + "[[slave.input]]\nentry = \"" + hex(entry.index) + ":" + hex(entry.subindex) + "\"\nvalue = 0\n";
    }
  }
  return text;
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  const MemoryFile file(input);
  std::string text;
  for (const auto byte : input) text += static_cast<char>(byte);
  const auto read = esi::read_esi(text, file.path());
  if (!read) return try_line("[[slave]]\nname = \"x\"\nesi = \"" + file.path() + "\"\n", "line.toml");
  for (std::size_t i = 0; i < std::min(read->devices.size(), kMaxDevices); ++i) {
    try_line(line_of(read->devices[i], file.path()), "line.toml");
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> inputs;
  const auto add = [&inputs](const std::string& text) {
    auto& bytes = inputs.emplace_back();
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  };
  for (const char* name : {"DI8", "DO4", "AI2", "MX4"}) add(esi::write_esi({example_device(name)}));
  auto empty = example_device("DI8");
  empty.tx_pdos.at(0).entries.at(0).bit_length = 0;  // an entry that the simulated device does not have
  add(esi::write_esi({empty}));
  auto drive = slaves::msd::device_description();
  if (drive.objects.size() > 6) drive.objects.resize(6);
  add(esi::write_esi({drive}));
  return inputs;
}

}  // namespace driveline::fuzz
