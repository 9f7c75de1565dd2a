#include "tshark.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

namespace driveline::replay {
namespace {

constexpr char kFieldSeparator = '|';
constexpr char kValueSeparator = ';';

/// Standard output of a shell command; the exit status is in `status`.
std::string run(const std::string& command, int& status) {
  std::string output;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::array<char, 65536> buffer{};
  for (std::size_t size = 0; (size = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    output.append(buffer.data(), size);
  }
  status = ::pclose(pipe);
  return output;
}

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (;;) {
    const auto end = text.find(separator);
    parts.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

void put(std::ofstream& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.put(static_cast<char>((value >> (8 * i)) & 0xFFU));
}

}  // namespace

bool tshark_available() {
  int status = 0;
  run("command -v tshark 2>/dev/null", status);
  return status == 0;
}

std::string missing_tshark_text() {
  return "tshark is not installed (Debian package tshark); it is the oracle of this test";
}

tl::expected<std::vector<DissectedPacket>, std::string> dissect(const std::filesystem::path& capture,
                                                                const std::string& display_filter,
                                                                const std::vector<std::string>& fields,
                                                                const std::string& decode_as) {
  const auto errors = std::filesystem::temp_directory_path() / (capture.filename().string() + ".tshark.err");
  std::string command = "tshark -n -r " + quoted(capture.string()) + " -T fields -E occurrence=a";
  command += " -E " + quoted(std::string("separator=") + kFieldSeparator);
  command += " -E " + quoted(std::string("aggregator=") + kValueSeparator);
  if (!decode_as.empty()) command += " -d " + quoted(decode_as);
  if (!display_filter.empty()) command += " -Y " + quoted(display_filter);
  for (const auto& field : fields) command += " -e " + quoted(field);
  command += " 2>" + quoted(errors.string());
  int status = 0;
  const std::string output = run(command, status);
  std::ifstream error_stream(errors);
  const std::string error_text{std::istreambuf_iterator<char>(error_stream), std::istreambuf_iterator<char>()};
  std::filesystem::remove(errors);
  if (status != 0) return tl::unexpected(error_text);

  std::vector<DissectedPacket> packets;
  for (const auto& line : split(output, '\n')) {
    if (line.empty()) continue;
    DissectedPacket packet;
    for (const auto& values : split(line, kFieldSeparator)) {
      packet.push_back(values.empty() ? FieldValues{} : split(values, kValueSeparator));
    }
    packets.push_back(std::move(packet));
  }
  return packets;
}

std::uint64_t to_number(std::string_view text) {
  if (text == "True") return 1;
  if (text == "False") return 0;
  const bool hexadecimal = text.starts_with("0x");
  if (hexadecimal) text.remove_prefix(2);
  std::uint64_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value, hexadecimal ? 16 : 10);
  if (problem != std::errc{} || end != text.data() + text.size()) {
    throw std::invalid_argument("not a number of tshark: " + std::string(text));
  }
  return value;
}

void write_pcap(const std::filesystem::path& file, std::span<const std::vector<std::byte>> frames,
                std::uint32_t link_type) {
  std::ofstream out(file, std::ios::binary);
  put(out, 0xA1B2C3D4, 4);  // microseconds
  put(out, 2, 2);           // version 2.4
  put(out, 4, 2);
  put(out, 0, 4);
  put(out, 0, 4);
  put(out, 262144, 4);  // snap length
  put(out, link_type, 4);
  std::uint32_t microseconds = 0;
  for (const auto& frame : frames) {
    put(out, 1, 4);
    put(out, microseconds++, 4);
    put(out, static_cast<std::uint32_t>(frame.size()), 4);
    put(out, static_cast<std::uint32_t>(frame.size()), 4);
    for (const std::byte b : frame) out.put(static_cast<char>(b));
  }
}

}  // namespace driveline::replay
