#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "units.hpp"

namespace driveline::bridge::clients {

/// Reason why a command fails: its exit status, and one sentence.
struct Failure {
  int status;  ///< 1: the operation failed; 2: the command line is wrong
  std::string text;
};
template <typename T>
using Outcome = tl::expected<T, Failure>;
/// Creates a failure of the operation.
[[nodiscard]] inline tl::unexpected<Failure> failed(std::string text) {
  return tl::unexpected(Failure{1, std::move(text)});
}
/// Creates a failure for a wrong command line.
[[nodiscard]] inline tl::unexpected<Failure> misused(std::string text) {
  return tl::unexpected(Failure{2, std::move(text)});
}

/// Files in a DDS Security folder, as created by scripts/dds-keys.sh.
inline constexpr const char* kSecurityFiles[] = {"identity_ca.pem",    "certificate.pem", "private_key.pem",
                                                 "permissions_ca.pem", "governance.p7s",  "permissions.p7s"};

/// Where to look for a line.
struct Place {
  std::uint32_t domain = 0;
  std::vector<std::string> interfaces;  ///< IPv4 addresses; empty: all
  std::vector<std::string> peers;       ///< IPv4 addresses of machines that multicast does not reach
  std::string partition;
  std::string security;  ///< folder with the six files of DDS Security; empty: no security

  [[nodiscard]] std::string text() const;  ///< e.g. "domain 3 on 127.0.0.1"
};

/// Longest wait for a line where no --timeout is given, s.
inline constexpr double kDefaultTimeoutSeconds = 10;

/// The command line of driveline-dds.
struct Options {
  std::string command;   ///< echo, record, plot, top
  std::string argument;  ///< argument without an option: a topic, a recording
  Place place;
  std::vector<std::string> topics;
  std::vector<std::string> axes;
  DisplayUnits units;  ///< units in which `plot` and `top` show the axes
  std::string output;
  std::optional<std::uint64_t> count;
  std::optional<double> duration_s;
  std::optional<double> timeout_s;
  std::optional<double> period_s;
  bool json = false;
  bool force = false;
  bool once = false;
  bool help = false;
};

/// Parses the command line; resolves names of interfaces to addresses.
[[nodiscard]] Outcome<Options> read_options(int count, const char* const* words);

extern const char* const kHelp;

}  // namespace driveline::bridge::clients
