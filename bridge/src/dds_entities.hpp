#pragma once

#include <tl/expected.hpp>
#include <utility>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"

namespace eprosima::fastdds::dds {
class DataWriter;
class DomainParticipant;
class Publisher;
class Topic;
}  // namespace eprosima::fastdds::dds

namespace driveline::bridge {

/// The DDS entities of one publisher, deleted in order by the destructor.
class DdsEntities {
 public:
  /// Creates participant, topics and writers for a checked configuration.
  [[nodiscard]] static tl::expected<DdsEntities, DdsError> create(const DdsConfig& config);
  ~DdsEntities();
  DdsEntities(DdsEntities&& other) noexcept
      : participant_(std::exchange(other.participant_, nullptr)),
        axis_writer_(other.axis_writer_),
        status_writer_(other.status_writer_),
        batch_writer_(other.batch_writer_),
        event_writer_(other.event_writer_),
        joint_writer_(other.joint_writer_) {}
  DdsEntities& operator=(DdsEntities&&) = delete;

  /// All return false when DDS refuses the sample.
  bool write_axis(void* message);
  bool write_status(void* message);
  bool write_batch(void* message);
  bool write_event(void* message);
  bool write_joints(void* message);

  /// Of the entities.
  [[nodiscard]] eprosima::fastdds::dds::DomainParticipant& participant() noexcept { return *participant_; }

  /// Somebody reads batches.
  [[nodiscard]] bool batch_has_readers() const;

  /// Waits, for a fraction of a second at most, until every subscriber has the last status.
  void wait_for_status_readers();

 private:
  DdsEntities() = default;
  tl::expected<void, DdsError> create_participant(const DdsConfig& config);
  tl::expected<void, DdsError> create_writers(const DdsConfig& config);

  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::DataWriter* axis_writer_ = nullptr;
  eprosima::fastdds::dds::DataWriter* status_writer_ = nullptr;
  eprosima::fastdds::dds::DataWriter* batch_writer_ = nullptr;  ///< null: there is no such topic
  eprosima::fastdds::dds::DataWriter* event_writer_ = nullptr;  ///< null: there is no such topic
  eprosima::fastdds::dds::DataWriter* joint_writer_ = nullptr;  ///< null: there is no such topic
};

}  // namespace driveline::bridge
