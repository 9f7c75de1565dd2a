#include "dds_entities.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <algorithm>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <mutex>

#include "drivelinePubSubTypes.h"
#include "joint_states.hpp"
#include "ros2PubSubTypes.h"

namespace driveline::bridge {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastdds::rtps;
using eprosima::fastrtps::Duration_t;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;

constexpr const char* kLoopback = "127.0.0.1";
constexpr const char* kDiscoveryMulticast = "239.255.0.1";  // RTPS 2.2, 9.6.1.4.1
constexpr std::uint32_t kParticipantsPerPeer = 16;          // participants of one machine found without multicast
constexpr std::int32_t kAxisHistory = 16;                   // samples kept per axis
constexpr std::int32_t kBatchHistory = 4;                   // batches
constexpr std::int32_t kJointHistory = 10;                  // messages
constexpr std::int32_t kEventHistory = 64;                  // as the IDL says
constexpr std::uint32_t kSharedMemorySegment = 256 * 1024;  // bytes
const Duration_t kFarewell{0, 300'000'000};                 // how long the last status may take to arrive

/// Fast DDS writes its log to stdout, which belongs to the program's own output.
void log_to_stderr() {
  static std::once_flag once;
  std::call_once(once, [] {
    auto consumer = std::make_unique<dds::StdoutErrConsumer>();
    consumer->stderr_threshold(dds::Log::Kind::Info);
    dds::Log::ClearConsumers();
    dds::Log::RegisterConsumer(std::move(consumer));
  });
}

Locator_t peer_locator(const std::string& address) {
  Locator_t locator;  // port 0: Fast DDS fills in the discovery ports of the domain
  locator.kind = LOCATOR_KIND_UDPv4;
  IPLocator::setIPv4(locator, address);
  return locator;
}

bool reaches_loopback(const DdsConfig& config) {
  return config.interfaces.empty() ||
         std::find(config.interfaces.begin(), config.interfaces.end(), kLoopback) != config.interfaces.end();
}

/// The plug-ins of the specification, which the packaged Fast DDS has built in.
void add_security(dds::DomainParticipantQos& qos, const DdsSecurity& files) {
  const std::string authentication = "dds.sec.auth.builtin.PKI-DH.";
  const std::string access = "dds.sec.access.builtin.Access-Permissions.";
  auto& properties = qos.properties().properties();
  properties.emplace_back("dds.sec.auth.plugin", "builtin.PKI-DH");
  properties.emplace_back("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  properties.emplace_back("dds.sec.access.plugin", "builtin.Access-Permissions");
  properties.emplace_back(authentication + "identity_ca", "file://" + files.identity_ca);
  properties.emplace_back(authentication + "identity_certificate", "file://" + files.certificate);
  properties.emplace_back(authentication + "private_key", "file://" + files.private_key);
  properties.emplace_back(access + "permissions_ca", "file://" + files.permissions_ca);
  properties.emplace_back(access + "governance", "file://" + files.governance);
  properties.emplace_back(access + "permissions", "file://" + files.permissions);
}

dds::DomainParticipantQos participant_qos(const DdsConfig& config) {
  dds::DomainParticipantQos qos;
  qos.name(config.participant_name.c_str());
  if (config.security) {
    add_security(qos, *config.security);
  }
  auto udp = std::make_shared<rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = config.interfaces;
  udp->non_blocking_send = true;  // rather lose a best-effort sample than wait for a full socket
  udp->maxInitialPeersRange = kParticipantsPerPeer;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  if (config.shared_memory) {
    auto shared_memory = std::make_shared<rtps::SharedMemTransportDescriptor>();
    shared_memory->segment_size(kSharedMemorySegment);
    qos.transport().user_transports.push_back(shared_memory);
  }
  auto& initial_peers = qos.wire_protocol().builtin.initialPeersList;
  initial_peers.push_back(peer_locator(kDiscoveryMulticast));
  if (reaches_loopback(config)) {
    initial_peers.push_back(peer_locator(kLoopback));
  }
  for (const std::string& peer : config.peers) {
    initial_peers.push_back(peer_locator(peer));
  }
  return qos;
}

/// Only the newest values matter: best effort, a short history per axis, allocated once.
dds::DataWriterQos axis_writer_qos(std::size_t axes) {
  const auto instances = static_cast<std::int32_t>(std::max<std::size_t>(axes, 1));
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kAxisHistory;
  qos.resource_limits().max_instances = instances;
  qos.resource_limits().max_samples_per_instance = kAxisHistory;
  qos.resource_limits().max_samples = instances * kAxisHistory;
  qos.resource_limits().allocated_samples = instances;
  qos.data_sharing().off();
  return qos;
}

/// A late subscriber must get the status, too: reliable, and the last sample is kept.
dds::DataWriterQos status_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = 1;
  qos.resource_limits().max_samples = 1;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  return qos;
}

/// A batch is large, and the next one comes in a millisecond.
dds::DataWriterQos batch_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kBatchHistory;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kBatchHistory;
  qos.resource_limits().max_samples = kBatchHistory;
  qos.resource_limits().allocated_samples = 1;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

/// What has happened is to be known to who comes later, too.
dds::DataWriterQos event_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kEventHistory;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kEventHistory;
  qos.resource_limits().max_samples = kEventHistory;
  qos.resource_limits().allocated_samples = kEventHistory;
  qos.data_sharing().off();
  return qos;
}

/// As writers of ROS 2 are by default: its readers are reliable, and do not match one that is not.
dds::DataWriterQos joint_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kJointHistory;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  const std::string hash{kJointStateTypeHash};
  qos.user_data().setValue({hash.begin(), hash.end()});
  return qos;
}

dds::DataWriter* create_writer(dds::DomainParticipant& participant, dds::Publisher& publisher,
                               const dds::TypeSupport& type, const std::string& topic_name,
                               const dds::DataWriterQos& qos) {
  if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK) {
    return nullptr;
  }
  dds::Topic* topic = participant.create_topic(topic_name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  return topic == nullptr ? nullptr : publisher.create_datawriter(topic, qos);
}

}  // namespace

tl::expected<DdsEntities, DdsError> DdsEntities::create(const DdsConfig& config) {
  log_to_stderr();
  DdsEntities entities;
  if (auto done = entities.create_participant(config); !done) {
    return tl::unexpected(std::move(done).error());
  }
  if (auto done = entities.create_writers(config); !done) {
    return tl::unexpected(std::move(done).error());
  }
  return entities;
}

DdsEntities::~DdsEntities() {
  if (participant_ != nullptr) {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
}

tl::expected<void, DdsError> DdsEntities::create_participant(const DdsConfig& config) {
  participant_ =
      dds::DomainParticipantFactory::get_instance()->create_participant(config.domain_id, participant_qos(config));
  if (participant_ == nullptr) {
    return tl::unexpected(DdsCannotJoin{config.domain_id, config.interfaces});
  }
  return {};
}

tl::expected<void, DdsError> DdsEntities::create_writers(const DdsConfig& config) {
  dds::Publisher* publisher = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  if (publisher == nullptr) {
    return tl::unexpected(DdsNoPublisher{});
  }
  axis_writer_ = create_writer(*participant_, *publisher, dds::TypeSupport{new telemetry::AxisTelemetryPubSubType},
                               config.axis_topic, axis_writer_qos(config.axes.size()));
  if (axis_writer_ == nullptr) {
    return tl::unexpected(DdsNoWriter{config.axis_topic});
  }
  status_writer_ = create_writer(*participant_, *publisher, dds::TypeSupport{new telemetry::LineStatusPubSubType},
                                 config.status_topic, status_writer_qos());
  if (status_writer_ == nullptr) {
    return tl::unexpected(DdsNoWriter{config.status_topic});
  }
  if (!config.batch_topic.empty()) {
    batch_writer_ = create_writer(*participant_, *publisher, dds::TypeSupport{new telemetry::AxisBatchPubSubType},
                                  config.batch_topic, batch_writer_qos());
    if (batch_writer_ == nullptr) {
      return tl::unexpected(DdsNoWriter{config.batch_topic});
    }
  }
  if (!config.event_topic.empty()) {
    event_writer_ = create_writer(*participant_, *publisher, dds::TypeSupport{new telemetry::EventPubSubType},
                                  config.event_topic, event_writer_qos());
    if (event_writer_ == nullptr) {
      return tl::unexpected(DdsNoWriter{config.event_topic});
    }
  }
  if (config.ros2) {
    joint_writer_ =
        create_writer(*participant_, *publisher, dds::TypeSupport{new sensor_msgs::msg::dds_::JointState_PubSubType},
                      kJointStatesTopic, joint_writer_qos());
    if (joint_writer_ == nullptr) {
      return tl::unexpected(DdsNoWriter{kJointStatesTopic});
    }
  }
  return {};
}

bool DdsEntities::write_axis(void* message) {
  return axis_writer_->write(message);
}

bool DdsEntities::write_status(void* message) {
  return status_writer_->write(message);
}

bool DdsEntities::write_batch(void* message) {
  return batch_writer_ != nullptr && batch_writer_->write(message);
}

bool DdsEntities::write_event(void* message) {
  return event_writer_ != nullptr && event_writer_->write(message);
}

bool DdsEntities::write_joints(void* message) {
  return joint_writer_ != nullptr && joint_writer_->write(message);
}

bool DdsEntities::batch_has_readers() const {
  if (batch_writer_ == nullptr) {
    return false;
  }
  dds::PublicationMatchedStatus matched;
  return batch_writer_->get_publication_matched_status(matched) == ReturnCode_t::RETCODE_OK &&
         matched.current_count > 0;
}

void DdsEntities::wait_for_status_readers() {
  status_writer_->wait_for_acknowledgments(kFarewell);
  if (event_writer_ != nullptr) {
    event_writer_->wait_for_acknowledgments(kFarewell);
  }
}

}  // namespace driveline::bridge
