#include "driveline/bridge/dds_setpoints.hpp"

#include <algorithm>
#include <chrono>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <utility>

#include "commandsPubSubTypes.h"
#include "driveline/bridge/dds_commands.hpp"
#include "driveline/bridge/dds_publisher.hpp"
#include "participant_gate.hpp"

namespace driveline::bridge {
namespace {

namespace dds = eprosima::fastdds::dds;
using snapshot::StreamedSetpoint;
using snapshot::StreamReport;

constexpr std::int32_t kSetpointHistory = 64;
constexpr std::int32_t kStatusHistory = 32;
/// Bytes of a GUID that identify its participant (RTPS 2.2, 8.2.4.2).
constexpr std::size_t kGuidPrefixBytes = 12;

/// Reliable; a batch without room waits at its writer.
dds::DataReaderQos setpoint_reader_qos() {
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kSetpointHistory;
  qos.resource_limits().max_samples = kSetpointHistory;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  return qos;
}

/// Reliable, but the writer never waits for readers; old samples are of no use.
dds::DataWriterQos status_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kStatusHistory;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kStatusHistory;
  qos.resource_limits().max_samples = kStatusHistory;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  return qos;
}

dds::Topic* stream_topic(dds::DomainParticipant& participant, const dds::TypeSupport& type, const char* name) {
  if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK) return nullptr;
  return participant.create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
}

/// The fields that all setpoints of a batch share.
StreamedSetpoint head_of(const commands::SetpointBatch& batch, const dds::SampleInfo& info) {
  StreamedSetpoint head;
  const auto writer = eprosima::fastrtps::rtps::iHandle2GUID(info.publication_handle);
  std::copy_n(writer.guidPrefix.value, kGuidPrefixBytes, head.participant.begin());
  head.client.set(batch.client().c_str());
  head.axis_count = static_cast<std::uint32_t>(std::min(batch.axes().size(), head.axes.size()));
  for (std::size_t i = 0; i < head.axis_count; ++i) {
    head.axes[i].name.set(batch.axes()[i].axis().c_str());
    head.axes[i].lease = batch.axes()[i].lease();
  }
  return head;
}

StreamedSetpoint setpoint_of(StreamedSetpoint head, std::uint64_t number, const commands::Setpoint& from) {
  head.kind = static_cast<std::uint32_t>(snapshot::SetpointKind::kGo);
  head.number = number;
  head.time_ns = from.time_ns();
  head.target_count = static_cast<std::uint32_t>(std::min(from.targets().size(), head.targets.size()));
  for (std::size_t i = 0; i < head.target_count; ++i) {
    const auto& target = from.targets()[i];
    head.targets[i] = {target.position(), target.velocity(), target.acceleration()};
  }
  return head;
}

}  // namespace

struct DdsSetpoints::State {
  dds::DataReader* reader = nullptr;
  dds::DataWriter* writer = nullptr;
  ParticipantGate gate{kParticipantRate, kParticipantAtOnce, DdsCommands::kMaxParticipants};
  commands::SetpointBatch batch;
};

tl::expected<std::unique_ptr<DdsSetpoints>, DdsError> DdsSetpoints::create(DdsPublisher& publisher) {
  auto& participant = publisher.participant();
  auto state = std::make_unique<State>();
  auto out_qos = dds::PUBLISHER_QOS_DEFAULT;
  auto in_qos = dds::SUBSCRIBER_QOS_DEFAULT;
  if (const auto& partition = publisher.partition(); !partition.empty()) {
    out_qos.partition().push_back(partition.c_str());
    in_qos.partition().push_back(partition.c_str());
  }
  auto* const out = participant.create_publisher(out_qos);
  auto* const statuses =
      stream_topic(participant, dds::TypeSupport{new commands::StreamStatusPubSubType}, kStreamStatusTopic);
  if (out != nullptr && statuses != nullptr) state->writer = out->create_datawriter(statuses, status_writer_qos());
  if (state->writer == nullptr) return tl::unexpected(DdsNoWriter{kStreamStatusTopic});
  auto* const in = participant.create_subscriber(in_qos);
  auto* const setpoints =
      stream_topic(participant, dds::TypeSupport{new commands::SetpointBatchPubSubType}, kSetpointTopic);
  if (in != nullptr && setpoints != nullptr) state->reader = in->create_datareader(setpoints, setpoint_reader_qos());
  if (state->reader == nullptr) return tl::unexpected(DdsNoReader{kSetpointTopic});
  return std::unique_ptr<DdsSetpoints>{new DdsSetpoints{std::move(state)}};
}

DdsSetpoints::DdsSetpoints(std::unique_ptr<State> state) : state_(std::move(state)) {}

/// The participant deletes its entities.
DdsSetpoints::~DdsSetpoints() = default;

bool DdsSetpoints::take(std::vector<StreamedSetpoint>& setpoints) {
  setpoints.clear();
  dds::SampleInfo info;
  auto& batch = state_->batch;
  if (state_->reader->take_next_sample(&batch, &info) != ReturnCode_t::RETCODE_OK) return false;
  if (!info.valid_data) return true;
  const auto now = std::chrono::steady_clock::now();
  auto head = head_of(batch, info);
  auto number = batch.number();
  for (const auto& setpoint : batch.setpoints()) {
    if (state_->gate.take(head.participant, now)) setpoints.push_back(setpoint_of(head, number, setpoint));
    ++number;
  }
  // Pass on the kind only if the batch carries more than setpoints.
  const bool more = batch.kind() != commands::SETPOINTS_GO || batch.setpoints().empty();
  if (!more || !state_->gate.take(head.participant, now)) return true;
  head.kind = static_cast<std::uint32_t>(batch.kind());
  setpoints.push_back(head);
  return true;
}

void DdsSetpoints::report(const StreamReport& report) {
  commands::StreamStatus message;
  message.participant(report.participant);
  message.client(std::string{report.client.view()}.c_str());
  message.state(static_cast<commands::StreamState>(report.state));
  message.stream_ns(report.stream_ns);
  message.newest_ns(report.newest_ns);
  message.taken(report.taken);
  message.refused(report.refused);
  message.starved(report.starved);
  message.text(std::string{report.text.view()}.c_str());
  message.axes().resize(std::min<std::size_t>(report.axis_count, report.axes.size()));
  for (std::size_t i = 0; i < message.axes().size(); ++i) {
    auto& to = message.axes()[i];
    const auto& from = report.axes[i];
    to.axis(std::string{from.name.view()}.c_str());
    to.following(from.following != 0);
    to.leased(from.leased != 0);
    to.setpoint(from.setpoint);
    to.position(from.position);
  }
  static_cast<void>(state_->writer->write(&message));
}

}  // namespace driveline::bridge
