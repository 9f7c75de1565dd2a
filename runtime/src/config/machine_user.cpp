#include "config/machine_user.hpp"

#include <pwd.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <system_error>

namespace driveline::runtime {
namespace {

/// Highest number of a user; the next one means "none".
constexpr std::uint32_t kLastUser = 0xFFFF'FFFEU;

}  // namespace

std::optional<MachineUser> find_user(const std::string& name) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool is_number = error == std::errc{} && end == name.data() + name.size();
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> texts{};
  if (is_number) {
    ::getpwuid_r(number, &entry, texts.data(), texts.size(), &found);
  } else {
    ::getpwnam_r(name.c_str(), &entry, texts.data(), texts.size(), &found);
  }
  if (found != nullptr) return MachineUser{name, found->pw_uid, found->pw_gid};
  if (!is_number || number > kLastUser) return std::nullopt;
  return MachineUser{name, number, number};
}

}  // namespace driveline::runtime
