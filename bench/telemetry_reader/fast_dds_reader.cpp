// Reads the telemetry batches of a line on the loopback interface with Fast DDS until SIGTERM, then prints statistics.
//
//   fast_dds_reader DOMAIN
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>

#include "drivelinePubSubTypes.h"
#include "received.h"

namespace {

namespace fast = eprosima::fastdds::dds;
using driveline::telemetry::AxisBatch;

Received received;

class Counting final : public fast::DataReaderListener {
 public:
  void on_data_available(fast::DataReader* reader) override {
    fast::SampleInfo info;
    while (reader->take_next_sample(&batch_, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      note_batch(&received, batch_.number(), batch_.samples().size());
      for (const auto& cycle : batch_.cycles()) note_cycle(&received, cycle.cycle(), cycle.wall_time_ns());
    }
  }

 private:
  AxisBatch batch_;
};

fast::DataReader* make_reader(fast::DomainParticipant& participant, Counting& listener) {
  fast::TypeSupport type{new driveline::telemetry::AxisBatchPubSubType};
  type.register_type(&participant);
  auto* topic = participant.create_topic("driveline/v1/axis_batch", type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  fast::DataReaderQos qos;
  qos.reliability().kind = fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 256;
  auto* subscriber = participant.create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  return subscriber->create_datareader(topic, qos, &listener);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fast_dds_reader DOMAIN\n");
    return 2;
  }
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &end, nullptr);
  fast::DomainParticipantQos qos;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = {"127.0.0.1"};
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  auto* factory = fast::DomainParticipantFactory::get_instance();
  auto* participant =
      factory->create_participant(static_cast<fast::DomainId_t>(std::strtoul(argv[1], nullptr, 10)), qos);
  Counting listener;
  auto* reader = participant == nullptr ? nullptr : make_reader(*participant, listener);
  if (reader == nullptr) {
    std::fprintf(stderr, "fast_dds_reader: cannot read domain %s\n", argv[1]);
    return 2;
  }
  int signal_number = 0;
  sigwait(&end, &signal_number);
  reader->set_listener(nullptr);
  print_received(&received);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return 0;
}
