#pragma once

#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <map>
#include <string>
#include <tl/expected.hpp>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"

namespace driveline::bridge {

/// Captures the log of Fast DDS during its lifetime instead of letting it go to stderr. One object at a time.
class HeardLog {
 public:
  HeardLog();
  ~HeardLog();
  HeardLog(const HeardLog&) = delete;
  HeardLog& operator=(const HeardLog&) = delete;

  /// The first error so far, as one line; empty: none.
  [[nodiscard]] std::string first() const;
};

/// From here on Fast DDS logs to stderr instead of stdout, which is reserved for the output of the program.
void log_to_stderr();

/// Fast DDS profiles with which the writers of a line are created.
class QosProfiles {
 public:
  /// Reads the profiles of `config`, and passes them to Fast DDS, for the whole process. Errors (DdsBadProfiles):
  /// invalid XML; elements other than <data_writer> profiles; a profile that matches no topic of a line, or occurs
  /// twice; settings that Fast DDS does not understand.
  [[nodiscard]] static tl::expected<QosProfiles, DdsError> load(const DdsConfig& config);

  /// QoS of a topic's writer from its profile, or `own` without a profile. A profile replaces everything except what
  /// the topic requires: room for all instances, the memory policy, and the type hash of ROS 2. Error (DdsBadProfiles):
  /// QoS that a bridge cannot support.
  [[nodiscard]] tl::expected<eprosima::fastdds::dds::DataWriterQos, DdsError> apply(
      eprosima::fastdds::dds::Publisher& publisher, const std::string& topic,
      const eprosima::fastdds::dds::DataWriterQos& own) const;
  /// Error for a writer that could not be created with the profile of its topic; `otherwise` if it has no profile.
  [[nodiscard]] DdsError blame(const std::string& topic, const std::string& reason, DdsError otherwise) const;

 private:
  std::string file_;
  std::map<std::string, int> lines_;  ///< line numbers of the profiles, by topic
};

}  // namespace driveline::bridge
