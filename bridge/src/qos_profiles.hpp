#pragma once

#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <map>
#include <string>
#include <tl/expected.hpp>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"

namespace driveline::bridge {

/// What Fast DDS says in its log while this exists, in place of telling it to stderr. One at a time.
class HeardLog {
 public:
  HeardLog();
  ~HeardLog();
  HeardLog(const HeardLog&) = delete;
  HeardLog& operator=(const HeardLog&) = delete;

  /// The first complaint so far, as one line; empty: none.
  [[nodiscard]] std::string first() const;
};

/// From here on Fast DDS logs to stderr, not to stdout, which belongs to the program's own output.
void log_to_stderr();

/// Profiles of Fast DDS by which the writers of a line are made.
class QosProfiles {
 public:
  /// Reads those of `config`, and hands them to Fast DDS, for the whole process. Errors (DdsBadProfiles): no XML;
  /// something but <data_writer> profiles; a profile of no topic of a line, or twice; what Fast DDS does not
  /// understand.
  [[nodiscard]] static tl::expected<QosProfiles, DdsError> load(const DdsConfig& config);

  /// The QoS of a topic's writer by its profile; `own` where there is none. A profile replaces all of it but what the
  /// topic cannot be without: room for all instances, the way its memory is had, and the type hash of ROS 2. Error
  /// (DdsBadProfiles): QoS that a bridge cannot have.
  [[nodiscard]] tl::expected<eprosima::fastdds::dds::DataWriterQos, DdsError> apply(
      eprosima::fastdds::dds::Publisher& publisher, const std::string& topic,
      const eprosima::fastdds::dds::DataWriterQos& own) const;
  /// Why there is no writer by the profile of a topic; `otherwise` where it has none.
  [[nodiscard]] DdsError blame(const std::string& topic, const std::string& reason, DdsError otherwise) const;

 private:
  std::string file_;
  std::map<std::string, int> lines_;  ///< of the profiles, by topic
};

}  // namespace driveline::bridge
