#pragma once

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <chrono>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivelinePubSubTypes.h"
#include "support/dds_domain.hpp"

namespace driveline::bridge::test {

namespace dds = eprosima::fastdds::dds;

using driveline::test::test_domain;

/// A Fast DDS subscriber on the loopback interface that stores all received messages.
template <class Message, class PubSubType>
class Subscriber {
 public:
  Subscriber(std::uint32_t domain, const std::string& topic_name, const dds::DataReaderQos& reader_qos) {
    dds::DomainParticipantQos qos;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {"127.0.0.1"};
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    dds::TypeSupport type{new PubSubType};
    type.register_type(participant_);
    dds::Topic* topic = participant_->create_topic(topic_name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
    reader_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT)->create_datareader(topic, reader_qos);
  }
  ~Subscriber() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  /// Takes the new messages and returns all messages so far.
  const std::vector<Message>& received() {
    Message message;
    dds::SampleInfo info;
    while (reader_->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) {
        received_.push_back(message);
      }
    }
    return received_;
  }

  /// Waits with a generous time-out until `count` messages have arrived, and calls `meanwhile` repeatedly. False:
  /// time-out.
  template <class Meanwhile>
  bool wait_for(std::size_t count, const Meanwhile& meanwhile) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{30};
    while (received().size() < count) {
      if (std::chrono::steady_clock::now() > deadline) {
        return false;
      }
      meanwhile();
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    return true;
  }
  bool wait_for(std::size_t count) {
    return wait_for(count, [] {});
  }

  int deadlines_missed() {
    dds::RequestedDeadlineMissedStatus missed;
    reader_->get_requested_deadline_missed_status(missed);
    return static_cast<int>(missed.total_count);
  }
  int writers_alive() {
    dds::LivelinessChangedStatus changed;
    reader_->get_liveliness_changed_status(changed);
    return changed.alive_count;
  }

  void forget() {
    received();
    received_.clear();
  }

 private:
  dds::DomainParticipant* participant_ = nullptr;
  dds::DataReader* reader_ = nullptr;
  std::vector<Message> received_;
};

inline dds::DataReaderQos axis_reader_qos() {
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 2000;
  qos.resource_limits().max_instances = 128;
  qos.resource_limits().max_samples_per_instance = 2000;
  qos.resource_limits().max_samples = 128 * 2000;
  return qos;
}

inline dds::DataReaderQos status_reader_qos() {
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 100;
  return qos;
}

struct AxisSubscriber : Subscriber<telemetry::AxisTelemetry, telemetry::AxisTelemetryPubSubType> {
  explicit AxisSubscriber(std::uint32_t domain) : Subscriber(domain, "driveline/axis_telemetry", axis_reader_qos()) {}
};

struct StatusSubscriber : Subscriber<telemetry::LineStatus, telemetry::LineStatusPubSubType> {
  explicit StatusSubscriber(std::uint32_t domain) : Subscriber(domain, "driveline/line_status", status_reader_qos()) {}
};

}  // namespace driveline::bridge::test
