#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace driveline::bridge {

/// A name is empty, or longer than the telemetry records allow.
struct DdsNameLength {
  std::optional<std::size_t> axis;  ///< index of the axis, from 0; nullopt: the name of the line
  std::string name;                 ///< as configured
};

/// A text that is not an IPv4 address.
struct DdsNoAddress {
  /// Purpose of the address.
  enum class Use : std::uint8_t { kInterface, kPeer, kDiscoveryServer };
  Use use;              ///< purpose of the address
  std::string address;  ///< as configured
};

/// An interface address that this machine does not have.
struct DdsForeignInterface {
  std::string address;           ///< as configured
  std::vector<std::string> own;  ///< addresses of this machine
};

/// More axes than the telemetry can number.
struct DdsTooManyAxes {
  std::size_t count;  ///< as configured
};

/// A domain that does not exist.
struct DdsDomainOutOfRange {
  std::uint32_t domain;  ///< as configured
  std::uint32_t last;    ///< highest valid domain
};

/// A decimation of 0.
struct DdsNoDecimation {};

/// Topics without a name, or with equal names.
struct DdsTopicNames {
  std::string axis_topic;    ///< as configured
  std::string status_topic;  ///< as configured
};

/// Fast DDS cannot join the domain; it gives the reason on stderr.
struct DdsCannotJoin {
  std::uint32_t domain;                 ///< as configured
  std::vector<std::string> interfaces;  ///< as configured; empty: all
};

/// Fast DDS cannot create the publisher.
struct DdsNoPublisher {};

/// Fast DDS cannot create a writer.
struct DdsNoWriter {
  std::string topic;  ///< topic of the writer
};

/// Fast DDS cannot create a reader.
struct DdsNoReader {
  std::string topic;  ///< topic of the reader
};

/// Profiles that Fast DDS does not accept.
struct DdsBadProfiles {
  std::string file;    ///< as configured
  int line = 0;        ///< line in the file; 0: unknown
  std::string reason;  ///< reason, without a full stop
};

/// Shared memory and DDS Security are both configured, an untested combination.
struct DdsSecureSharedMemory {};

/// Reasons why a line is not published.
using DdsError = std::variant<DdsNameLength, DdsNoAddress, DdsForeignInterface, DdsTooManyAxes, DdsDomainOutOfRange,
                              DdsNoDecimation, DdsTopicNames, DdsCannotJoin, DdsNoPublisher, DdsNoWriter, DdsNoReader,
                              DdsBadProfiles, DdsSecureSharedMemory>;

/// The error as a sentence that names the wrong value or the step that failed.
[[nodiscard]] std::string describe(const DdsError& error);

}  // namespace driveline::bridge
