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

#include "diagnostics.hpp"
#include "drivelinePubSubTypes.h"
#include "joint_states.hpp"
#include "ros2PubSubTypes.h"
#include "writer_qos.hpp"

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

std::string name_of(TopicId topic, const DdsConfig& config) {
  switch (topic) {
    case TopicId::kAxis:
      return config.axis_topic;
    case TopicId::kStatus:
      return config.status_topic;
    case TopicId::kBatch:
      return config.batch_topic;
    case TopicId::kEvent:
      return config.event_topic;
    case TopicId::kSlave:
      return config.slave_topic;
    case TopicId::kTopology:
      return config.topology_topic;
    case TopicId::kStatistics:
      return config.statistics_topic;
    case TopicId::kAxisStatus:
      return config.axis_state_topic;
    case TopicId::kDiagnostics:
      return config.ros2 ? kDiagnosticsTopic : "";
    case TopicId::kJoints:
      return config.ros2 ? kJointStatesTopic : "";
  }
  return {};
}

dds::TypeSupport type_of(TopicId topic) {
  switch (topic) {
    case TopicId::kAxis:
      return dds::TypeSupport{new telemetry::AxisTelemetryPubSubType};
    case TopicId::kStatus:
      return dds::TypeSupport{new telemetry::LineStatusPubSubType};
    case TopicId::kBatch:
      return dds::TypeSupport{new telemetry::AxisBatchPubSubType};
    case TopicId::kEvent:
      return dds::TypeSupport{new telemetry::EventPubSubType};
    case TopicId::kSlave:
      return dds::TypeSupport{new telemetry::SlavePubSubType};
    case TopicId::kTopology:
      return dds::TypeSupport{new telemetry::TopologyPubSubType};
    case TopicId::kStatistics:
      return dds::TypeSupport{new telemetry::CycleStatisticsPubSubType};
    case TopicId::kAxisStatus:
      return dds::TypeSupport{new telemetry::AxisStatusPubSubType};
    case TopicId::kDiagnostics:
      return dds::TypeSupport{new diagnostic_msgs::msg::dds_::DiagnosticArray_PubSubType};
    case TopicId::kJoints:
      return dds::TypeSupport{new sensor_msgs::msg::dds_::JointState_PubSubType};
  }
  return {};
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
  for (std::size_t i = 0; i < kTopics; ++i) {
    const auto topic = static_cast<TopicId>(i);
    const std::string name = name_of(topic, config);
    if (name.empty()) {
      continue;
    }
    writers_[i] = create_writer(*participant_, *publisher, type_of(topic), name, writer_qos(topic, config));
    if (writers_[i] == nullptr) {
      return tl::unexpected(DdsNoWriter{name});
    }
  }
  return {};
}

bool DdsEntities::write(TopicId topic, void* message) {
  dds::DataWriter* writer = writers_[static_cast<std::size_t>(topic)];
  return writer != nullptr && writer->write(message);
}

bool DdsEntities::has_readers(TopicId topic) const {
  dds::DataWriter* const writer = writers_[static_cast<std::size_t>(topic)];
  dds::PublicationMatchedStatus matched;
  return writer != nullptr && writer->get_publication_matched_status(matched) == ReturnCode_t::RETCODE_OK &&
         matched.current_count > 0;
}

void DdsEntities::wait_for_readers() {
  // Those whose last sample tells how a line was in the end; the first has the longest way.
  for (const TopicId topic :
       {TopicId::kStatus, TopicId::kEvent, TopicId::kSlave, TopicId::kStatistics, TopicId::kAxisStatus}) {
    if (dds::DataWriter* writer = writers_[static_cast<std::size_t>(topic)]; writer != nullptr) {
      writer->wait_for_acknowledgments(kFarewell);
    }
  }
}

}  // namespace driveline::bridge
