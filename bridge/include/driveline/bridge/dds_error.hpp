#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace driveline::bridge {

/// A name is empty, or longer than the records of the telemetry hold.
struct DdsNameLength {
  std::optional<std::size_t> axis;  ///< index of the axis, from 0; nothing: it is the name of the line
  std::string name;                 ///< as configured
};

/// An address that is no IPv4 address.
struct DdsNoAddress {
  /// Purpose of the address.
  enum class Use : std::uint8_t { kInterface, kPeer, kDiscoveryServer };
  Use use;              ///< purpose of the address
  std::string address;  ///< as configured
};

/// An interface whose address this machine does not have.
struct DdsForeignInterface {
  std::string address;           ///< as configured
  std::vector<std::string> own;  ///< those of this machine
};

/// More axes than the telemetry can number.
struct DdsTooManyAxes {
  std::size_t count;  ///< as configured
};

/// A domain that does not exist.
struct DdsDomainOutOfRange {
  std::uint32_t domain;  ///< as configured
  std::uint32_t last;    ///< highest domain
};

/// A decimation of 0.
struct DdsNoDecimation {};

/// Topics without a name, or with the same.
struct DdsTopicNames {
  std::string axis_topic;    ///< as configured
  std::string status_topic;  ///< as configured
};

/// Fast DDS refuses to join the domain; it says why on stderr.
struct DdsCannotJoin {
  std::uint32_t domain;                 ///< as configured
  std::vector<std::string> interfaces;  ///< as configured; empty: all
};

/// Fast DDS refuses to make the publisher.
struct DdsNoPublisher {};

/// Fast DDS refuses to make a writer.
struct DdsNoWriter {
  std::string topic;  ///< topic of the writer
};

/// Fast DDS refuses to make a reader.
struct DdsNoReader {
  std::string topic;  ///< topic of the reader
};

/// Profiles that Fast DDS cannot have.
struct DdsBadProfiles {
  std::string file;    ///< as configured
  int line = 0;        ///< in the file; 0: not known
  std::string reason;  ///< without a stop
};

/// Shared memory and DDS Security together, which nobody has tried.
struct DdsSecureSharedMemory {};

/// Why a line is not published.
using DdsError = std::variant<DdsNameLength, DdsNoAddress, DdsForeignInterface, DdsTooManyAxes, DdsDomainOutOfRange,
                              DdsNoDecimation, DdsTopicNames, DdsCannotJoin, DdsNoPublisher, DdsNoWriter, DdsNoReader,
                              DdsBadProfiles, DdsSecureSharedMemory>;

/// The error as a sentence that names the value that is wrong or the step that failed.
[[nodiscard]] std::string describe(const DdsError& error);

}  // namespace driveline::bridge
