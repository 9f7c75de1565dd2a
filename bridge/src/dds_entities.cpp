#include "dds_entities.hpp"

#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <algorithm>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <mutex>

#include "diagnostics.hpp"
#include "drivelinePubSubTypes.h"
#include "joint_states.hpp"
#include "qos_profiles.hpp"
#include "ros2PubSubTypes.h"
#include "shared_memory.hpp"
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
constexpr std::uint32_t kParticipantsPerPeer = 16;          // participants per machine found without multicast
const Duration_t kFarewell{0, 300'000'000};                 // longest wait for delivery of the last status

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

/// Configures discovery by the server only.
void ask(const DdsDiscoveryServer& server, eprosima::fastrtps::rtps::DiscoverySettings& discovery) {
  eprosima::fastrtps::rtps::RemoteServerAttributes asked;
  asked.ReadguidPrefix(eprosima::fastdds::rtps::DEFAULT_ROS2_SERVER_GUIDPREFIX);
  auto locator = peer_locator(server.address);
  IPLocator::setPhysicalPort(locator, server.port);
  asked.metatrafficUnicastLocatorList.push_back(locator);
  discovery.discoveryProtocol = eprosima::fastrtps::rtps::DiscoveryProtocol_t::CLIENT;
  discovery.m_DiscoveryServers.push_back(asked);
}

/// Creates a publisher in the partition of the line, or in the default partition for topics of ROS 2.
dds::Publisher* create_publisher(dds::DomainParticipant& participant, const std::string& partition) {
  auto qos = dds::PUBLISHER_QOS_DEFAULT;
  if (!partition.empty()) qos.partition().push_back(partition.c_str());
  return participant.create_publisher(qos);
}

bool of_ros2(TopicId topic) {
  return topic == TopicId::kDiagnostics || topic == TopicId::kJoints;
}

/// Adds the plug-ins of the DDS Security specification, which the packaged Fast DDS has built in.
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
  udp->non_blocking_send = true;  // losing a best-effort sample is better than waiting for a full socket
  udp->maxInitialPeersRange = kParticipantsPerPeer;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  if (config.shared_memory) {
    qos.transport().user_transports.push_back(shared_memory_to_own_user());
  }
  if (config.discovery_server) {
    ask(*config.discovery_server, qos.wire_protocol().builtin.discovery_config);
    return qos;
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
  static std::once_flag once;
  std::call_once(once, log_to_stderr);
  // Load the profiles before creating the participant: errors that Fast DDS logs meanwhile concern the profiles, not
  // the network.
  auto profiles = QosProfiles::load(config);
  if (!profiles) {
    return tl::unexpected(std::move(profiles).error());
  }
  DdsEntities entities;
  if (auto done = entities.create_participant(config); !done) {
    return tl::unexpected(std::move(done).error());
  }
  if (auto done = entities.create_writers(config, *profiles); !done) {
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

tl::expected<void, DdsError> DdsEntities::create_writers(const DdsConfig& config, const QosProfiles& profiles) {
  dds::Publisher* const own = create_publisher(*participant_, config.partition);
  dds::Publisher* const others = config.partition.empty() ? own : create_publisher(*participant_, "");
  if (own == nullptr || others == nullptr) {
    return tl::unexpected(DdsNoPublisher{});
  }
  for (std::size_t i = 0; i < kTopics; ++i) {
    const auto topic = static_cast<TopicId>(i);
    if (auto made = create_writer_of(topic, config, profiles, of_ros2(topic) ? *others : *own); !made) {
      return made;
    }
  }
  return {};
}

tl::expected<void, DdsError> DdsEntities::create_writer_of(TopicId topic, const DdsConfig& config,
                                                           const QosProfiles& profiles, dds::Publisher& publisher) {
  const std::string name = name_of(topic, config);
  if (name.empty()) {
    return {};
  }
  const auto qos = profiles.apply(publisher, name, writer_qos(topic, config));
  if (!qos) {
    return tl::unexpected(qos.error());
  }
  auto& writer = writers_[static_cast<std::size_t>(topic)];
  std::string complaint;
  if (config.profiles.xml.empty()) {
    writer = create_writer(*participant_, publisher, type_of(topic), name, *qos);
  } else {
    const HeardLog heard;
    writer = create_writer(*participant_, publisher, type_of(topic), name, *qos);
    complaint = heard.first();
  }
  if (writer == nullptr) {
    return tl::unexpected(profiles.blame(name, complaint, DdsNoWriter{name}));
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
  // Topics whose last sample shows the final state of the line; the first one takes longest.
  for (const TopicId topic :
       {TopicId::kStatus, TopicId::kEvent, TopicId::kSlave, TopicId::kStatistics, TopicId::kAxisStatus}) {
    if (dds::DataWriter* writer = writers_[static_cast<std::size_t>(topic)]; writer != nullptr) {
      writer->wait_for_acknowledgments(kFarewell);
    }
  }
}

}  // namespace driveline::bridge
