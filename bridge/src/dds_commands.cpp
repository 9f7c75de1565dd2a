#include "driveline/bridge/dds_commands.hpp"

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
#include "driveline/bridge/dds_publisher.hpp"
#include "participant_gate.hpp"

namespace driveline::bridge {
namespace {

namespace dds = eprosima::fastdds::dds;
using snapshot::CommandAnswer;
using snapshot::CommandRecord;
using snapshot::CommandResult;

constexpr std::int32_t kCommandHistory = 512;
constexpr std::int32_t kAnswerHistory = 256;
/// Maximum number of samples that take() skips per call.
constexpr int kMaxLooks = 512;
constexpr double kRefusalsPerSecond = 100.0;
/// Bytes of a GUID that identify its participant (RTPS 2.2, 8.2.4.2).
constexpr std::size_t kPrefixBytes = 12;

/// Reliable; a command without room waits at its writer, which is slowed down.
dds::DataReaderQos command_reader_qos() {
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kCommandHistory;
  qos.resource_limits().max_samples = kCommandHistory;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  return qos;
}

/// Reliable, but the writer never waits for readers. The last answers are stored: a client may send a command before
/// its reader has been discovered here.
dds::DataWriterQos answer_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kAnswerHistory;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kAnswerHistory;
  qos.resource_limits().max_samples = kAnswerHistory;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  return qos;
}

CommandRecord record_of(const commands::Command& command, const dds::SampleInfo& info) {
  CommandRecord record;
  const auto writer = eprosima::fastrtps::rtps::iHandle2GUID(info.publication_handle);
  std::copy_n(writer.guidPrefix.value, kPrefixBytes, record.participant.begin());
  record.client.set(command.client().c_str());
  record.axis.set(command.axis().c_str());
  record.number = command.number();
  record.lease = command.lease();
  record.kind = static_cast<std::uint32_t>(command.kind());
  record.target = command.target();
  record.velocity = command.velocity();
  record.acceleration = command.acceleration();
  record.deceleration = command.deceleration();
  record.jerk = command.jerk();
  return record;
}

dds::Topic* create_topic(dds::DomainParticipant& participant, const dds::TypeSupport& type, const char* name) {
  if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK) {
    return nullptr;
  }
  return participant.create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
}

dds::DataReader* create_reader(dds::DomainParticipant& participant, const std::string& partition) {
  auto qos = dds::SUBSCRIBER_QOS_DEFAULT;
  if (!partition.empty()) qos.partition().push_back(partition.c_str());
  auto* const subscriber = participant.create_subscriber(qos);
  auto* const topic = create_topic(participant, dds::TypeSupport{new commands::CommandPubSubType}, kCommandTopic);
  return subscriber == nullptr || topic == nullptr ? nullptr
                                                   : subscriber->create_datareader(topic, command_reader_qos());
}

dds::DataWriter* create_answer_writer(dds::DomainParticipant& participant, const std::string& partition) {
  auto qos = dds::PUBLISHER_QOS_DEFAULT;
  if (!partition.empty()) qos.partition().push_back(partition.c_str());
  auto* const publisher = participant.create_publisher(qos);
  auto* const topic =
      create_topic(participant, dds::TypeSupport{new commands::CommandAnswerPubSubType}, kCommandAnswerTopic);
  return publisher == nullptr || topic == nullptr ? nullptr : publisher->create_datawriter(topic, answer_writer_qos());
}

}  // namespace

struct DdsCommands::State {
  dds::DataReader* reader = nullptr;
  dds::DataWriter* writer = nullptr;
  ParticipantGate gate{kParticipantRate, kParticipantAtOnce, kMaxParticipants};
  ParticipantGate refusals{kRefusalsPerSecond, kRefusalsPerSecond, 1};
  commands::Command command;
};

tl::expected<std::unique_ptr<DdsCommands>, DdsError> DdsCommands::create(DdsPublisher& publisher) {
  auto& participant = publisher.participant();
  auto state = std::make_unique<State>();
  state->writer = create_answer_writer(participant, publisher.partition());
  if (state->writer == nullptr) return tl::unexpected(DdsNoWriter{kCommandAnswerTopic});
  state->reader = create_reader(participant, publisher.partition());
  if (state->reader == nullptr) return tl::unexpected(DdsNoReader{kCommandTopic});
  return std::unique_ptr<DdsCommands>{new DdsCommands{std::move(state)}};
}

DdsCommands::DdsCommands(std::unique_ptr<State> state) : state_(std::move(state)) {}

/// The participant deletes its entities.
DdsCommands::~DdsCommands() = default;

bool DdsCommands::take(snapshot::CommandRecord& record) {
  dds::SampleInfo info;
  for (int i = 0; i < kMaxLooks; ++i) {
    if (state_->reader->take_next_sample(&state_->command, &info) != ReturnCode_t::RETCODE_OK) return false;
    if (!info.valid_data) continue;
    record = record_of(state_->command, info);
    if (state_->gate.take(record.participant, std::chrono::steady_clock::now())) return true;
  }
  return false;
}

void DdsCommands::answer(const snapshot::CommandAnswer& answer) {
  commands::CommandAnswer message;
  message.participant(answer.participant);
  message.client(std::string{answer.client.view()}.c_str());
  message.number(answer.number);
  message.result(static_cast<commands::CommandResult>(answer.result));
  message.axis(std::string{answer.axis.view()}.c_str());
  message.lease(answer.lease);
  message.text(std::string{answer.text.view()}.c_str());
  static_cast<void>(state_->writer->write(&message));
}

void DdsCommands::refuse(const snapshot::CommandRecord& record) {
  if (!state_->refusals.take({}, std::chrono::steady_clock::now())) return;
  CommandAnswer answer;
  answer.participant = record.participant;
  answer.client = record.client;
  answer.axis = record.axis;
  answer.number = record.number;
  answer.lease = record.lease;  // the lease is unchanged
  answer.result = static_cast<std::uint32_t>(CommandResult::kRefused);
  answer.text.set("too many commands: the command queue of the line is full");
  this->answer(answer);
}

}  // namespace driveline::bridge
