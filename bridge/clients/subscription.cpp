#include "subscription.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fmt/format.h>

#include <algorithm>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <utility>

namespace driveline::bridge::clients {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastdds::rtps;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

constexpr const char* kLoopback = "127.0.0.1";
constexpr const char* kDiscoveryMulticast = "239.255.0.1";  // RTPS 2.2, 9.6.1.4.1
constexpr std::uint32_t kParticipantsPerPeer = 16;          // participants per machine found without multicast
constexpr std::uint32_t kReceiveBuffer = 8 * 1024 * 1024;   // bytes; the kernel may give less (net.core.rmem_max)
constexpr std::int32_t kHistory = 4096;                     // samples per instance that wait to be taken
constexpr std::uint32_t kLargestSample = 65536;             // bytes: the size of the largest datagram

using RawSample = std::vector<std::uint8_t>;

/// A type of which only the name and the key are known; its samples are raw bytes.
class RawType final : public dds::TopicDataType {
 public:
  explicit RawType(const Topic& topic) : structure_(topic.structure) {
    setName(std::string(topic.type).c_str());
    m_typeSize = kLargestSample;
    const auto fields = topic.structure->fields;
    m_isGetKeyDefined = std::any_of(fields.begin(), fields.end(), [](const Field& field) { return field.key; });
  }

  // this type is never written
  bool serialize(void* /*data*/, SerializedPayload_t* /*payload*/) override { return false; }

  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<RawSample*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<RawSample*>(data)->size()); };
  }

  void* createData() override { return new RawSample; }
  void deleteData(void* data) override { delete static_cast<RawSample*>(data); }

  bool getKey(void* data, InstanceHandle_t* handle, bool /*force_md5*/) override {
    const auto key = m_isGetKeyDefined ? key_of(*structure_, *static_cast<RawSample*>(data)) : std::nullopt;
    if (!key) return false;
    for (std::size_t i = 0; i < key->size(); ++i) handle->value[i] = (*key)[i];
    return true;
  }

 private:
  const StructType* structure_;
};

/// Fast DDS writes its log to stdout, which carries the samples. Its warnings about single messages of other
/// participants are of no use to the user, so only errors are logged, to stderr.
void log_errors_to_stderr() {
  auto consumer = std::make_unique<dds::StdoutErrConsumer>();
  consumer->stderr_threshold(dds::Log::Kind::Info);
  dds::Log::ClearConsumers();
  dds::Log::RegisterConsumer(std::move(consumer));
  dds::Log::SetVerbosity(dds::Log::Kind::Error);
}

Locator_t locator_of(const std::string& address) {
  Locator_t locator;  // port 0: Fast DDS fills in the discovery ports of the domain
  locator.kind = LOCATOR_KIND_UDPv4;
  IPLocator::setIPv4(locator, address);
  return locator;
}

/// Adds the plug-ins of the DDS Security specification, which the packaged Fast DDS has built in.
void add_keys(dds::DomainParticipantQos& qos, const std::string& folder) {
  const std::string authentication = "dds.sec.auth.builtin.PKI-DH.";
  const std::string access = "dds.sec.access.builtin.Access-Permissions.";
  const auto file = [&](const char* name) { return "file://" + folder + '/' + name; };
  auto& properties = qos.properties().properties();
  properties.emplace_back("dds.sec.auth.plugin", "builtin.PKI-DH");
  properties.emplace_back("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  properties.emplace_back("dds.sec.access.plugin", "builtin.Access-Permissions");
  properties.emplace_back(authentication + "identity_ca", file("identity_ca.pem"));
  properties.emplace_back(authentication + "identity_certificate", file("certificate.pem"));
  properties.emplace_back(authentication + "private_key", file("private_key.pem"));
  properties.emplace_back(access + "permissions_ca", file("permissions_ca.pem"));
  properties.emplace_back(access + "governance", file("governance.p7s"));
  properties.emplace_back(access + "permissions", file("permissions.p7s"));
}

dds::DomainParticipantQos participant_qos(const Place& place) {
  dds::DomainParticipantQos qos;
  if (!place.security.empty()) add_keys(qos, place.security);
  qos.name("driveline-dds");
  auto udp = std::make_shared<rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = place.interfaces;
  udp->maxInitialPeersRange = kParticipantsPerPeer;
  udp->receiveBufferSize = kReceiveBuffer;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  auto& peers = qos.wire_protocol().builtin.initialPeersList;
  peers.push_back(locator_of(kDiscoveryMulticast));
  const auto& own = place.interfaces;
  if (own.empty() || std::find(own.begin(), own.end(), kLoopback) != own.end()) peers.push_back(locator_of(kLoopback));
  for (const auto& peer : place.peers) peers.push_back(locator_of(peer));
  return qos;
}

dds::DataReaderQos reader_qos(const Topic& topic) {
  dds::DataReaderQos qos;
  qos.reliability().kind = topic.kept ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = topic.kept ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kHistory;
  qos.resource_limits().max_instances = 0;  // no limit
  qos.resource_limits().max_samples = 0;
  qos.resource_limits().max_samples_per_instance = kHistory;
  qos.resource_limits().allocated_samples = 0;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

struct Arrival {
  const Topic* topic;
  RawSample bytes;
  std::int64_t received_ns;
  std::int64_t published_ns;
};

}  // namespace

struct Subscription::Entities {
  struct TopicReader {
    const Topic* topic;
    dds::DataReader* reader;
  };

  dds::DomainParticipant* participant = nullptr;
  std::vector<TopicReader> readers;
  dds::WaitSet waitset;

  Entities() = default;
  Entities(const Entities&) = delete;
  Entities& operator=(const Entities&) = delete;
  ~Entities() {
    if (participant == nullptr) return;
    for (const auto& each : readers) waitset.detach_condition(each.reader->get_statuscondition());
    participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }

  bool add_reader(dds::Subscriber& subscriber, const Topic& topic) {
    const dds::TypeSupport type(new RawType(topic));
    if (type.register_type(participant) != ReturnCode_t::RETCODE_OK) return false;
    auto* const made = participant->create_topic(std::string(topic.name), type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
    auto* const reader = made == nullptr ? nullptr : subscriber.create_datareader(made, reader_qos(topic));
    if (reader == nullptr) return false;
    auto& condition = reader->get_statuscondition();
    condition.set_enabled_statuses(dds::StatusMask::data_available());
    waitset.attach_condition(condition);
    readers.push_back({&topic, reader});
    return true;
  }
};

Subscription::Subscription(std::unique_ptr<Entities> entities) : entities_(std::move(entities)) {}
Subscription::Subscription(Subscription&& other) noexcept = default;
Subscription::~Subscription() = default;

Outcome<Subscription> Subscription::create(const Place& place, std::span<const Topic* const> chosen) {
  log_errors_to_stderr();
  auto entities = std::make_unique<Entities>();
  auto* const factory = dds::DomainParticipantFactory::get_instance();
  entities->participant = factory->create_participant(place.domain, participant_qos(place));
  if (entities->participant == nullptr) return failed(fmt::format("Fast DDS cannot join {}", place.text()));
  auto qos = dds::SUBSCRIBER_QOS_DEFAULT;
  if (!place.partition.empty()) qos.partition().push_back(place.partition.c_str());
  auto* const subscriber = entities->participant->create_subscriber(qos);
  if (subscriber == nullptr) return failed("Fast DDS cannot create a subscriber");
  for (const auto* topic : chosen) {
    if (entities->add_reader(*subscriber, *topic)) continue;
    if (place.security.empty()) return failed(fmt::format("Fast DDS cannot create a reader of {}", topic->name));
    return failed(fmt::format("{}: the permissions in {} do not allow reading it", topic->name, place.security));
  }
  return Subscription(std::move(entities));
}

std::size_t Subscription::take(std::chrono::milliseconds limit, const std::function<void(const Sample&)>& take) {
  dds::ConditionSeq active;
  const auto seconds = static_cast<std::int32_t>(limit.count() / 1000);
  const auto rest_ns = static_cast<std::uint32_t>(limit.count() % 1000) * 1'000'000U;
  entities_->waitset.wait(active, eprosima::fastrtps::Duration_t(seconds, rest_ns));
  // Fast DDS returns the samples instance by instance.
  std::vector<Arrival> arrivals;
  for (const auto& [topic, reader] : entities_->readers) {
    Arrival next{topic, {}, 0, 0};
    dds::SampleInfo info;
    while (reader->take_next_sample(&next.bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      next.received_ns = info.reception_timestamp.to_ns();
      next.published_ns = info.source_timestamp.to_ns();
      arrivals.push_back(std::exchange(next, {topic, {}, 0, 0}));
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.received_ns < b.received_ns; });
  for (const auto& each : arrivals) take({each.topic, each.bytes, each.received_ns, each.published_ns});
  return arrivals.size();
}

int Subscription::writers(const Topic& topic) const {
  const auto& all = entities_->readers;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.topic == &topic; });
  dds::SubscriptionMatchedStatus matched;
  if (found == all.end() || found->reader->get_subscription_matched_status(matched) != ReturnCode_t::RETCODE_OK)
    return 0;
  return matched.current_count;
}

}  // namespace driveline::bridge::clients
