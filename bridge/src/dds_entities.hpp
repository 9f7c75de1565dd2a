#pragma once

#include <array>
#include <cstddef>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"
#include "topic_id.hpp"

namespace eprosima::fastdds::dds {
class DataWriter;
class DomainParticipant;
class Publisher;
class Topic;
}  // namespace eprosima::fastdds::dds

namespace driveline::bridge {

class QosProfiles;

/// The DDS entities of a publisher, deleted in order by the destructor.
class DdsEntities {
 public:
  /// Creates participant, topics and writers for a checked configuration.
  [[nodiscard]] static tl::expected<DdsEntities, DdsError> create(const DdsConfig& config);
  ~DdsEntities();
  DdsEntities(DdsEntities&& other) noexcept
      : participant_(std::exchange(other.participant_, nullptr)), writers_(other.writers_) {}
  DdsEntities& operator=(DdsEntities&&) = delete;

  /// Publishes a message. Returns false if DDS refuses it, or there is no such topic. `message`: of the type of the
  /// topic.
  bool write(TopicId topic, void* message);

  /// Whether the topic has a matched reader.
  [[nodiscard]] bool has_readers(TopicId topic) const;
  /// Participant of the entities.
  [[nodiscard]] eprosima::fastdds::dds::DomainParticipant& participant() noexcept { return *participant_; }

  /// Waits, at most a fraction of a second per topic, until every subscriber has received the last status.
  void wait_for_readers();

 private:
  DdsEntities() = default;
  tl::expected<void, DdsError> create_participant(const DdsConfig& config);
  tl::expected<void, DdsError> create_writers(const DdsConfig& config, const QosProfiles& profiles);
  tl::expected<void, DdsError> create_writer_of(TopicId topic, const DdsConfig& config, const QosProfiles& profiles,
                                                eprosima::fastdds::dds::Publisher& publisher);

  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  std::array<eprosima::fastdds::dds::DataWriter*, kTopics> writers_{};  ///< by TopicId; null: not published
};

}  // namespace driveline::bridge
