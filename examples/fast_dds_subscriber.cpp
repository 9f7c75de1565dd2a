// Prints the positions of the axes of a line, received over DDS: fast_dds_subscriber [DOMAIN [SAMPLES]]. Uses Fast DDS;
// `fastddsgen driveline.idl` generates the types. Links nothing of driveline.
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <memory>

#include "drivelinePubSubTypes.h"

using namespace eprosima::fastdds::dds;
using driveline::telemetry::AxisTelemetry;

int main(int argc, char** argv) {
  const auto domain = static_cast<unsigned>(argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 0);
  auto samples = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1000;
  // By default a line publishes on loopback, which Fast DDS does not use on its own.
  DomainParticipantQos qos;
  const auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  loopback->interfaceWhiteList = {"127.0.0.1"};
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(loopback);
  auto* const participant = DomainParticipantFactory::get_instance()->create_participant(domain, qos);
  if (participant == nullptr) return EXIT_FAILURE;
  const TypeSupport type(new driveline::telemetry::AxisTelemetryPubSubType);
  type.register_type(participant);
  auto* const topic = participant->create_topic("driveline/axis_telemetry", type.get_type_name(), TOPIC_QOS_DEFAULT);
  auto* const subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  DataReaderQos reader_qos;                           // best effort, like the writer
  reader_qos.resource_limits().max_instances = 1024;  // axes; the default is 10
  reader_qos.resource_limits().max_samples = 1024 * reader_qos.resource_limits().max_samples_per_instance;
  auto* const reader = subscriber->create_datareader(topic, reader_qos);
  if (reader == nullptr) return EXIT_FAILURE;
  while (samples > 0 && reader->wait_for_unread_message({10, 0})) {
    AxisTelemetry sample;
    SampleInfo info;
    while (samples > 0 && reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      const char* unit = sample.kind() == driveline::telemetry::AXIS_ROTARY ? "rad" : "m";
      std::printf("cycle %llu: %s is at %.6f %s\n", static_cast<unsigned long long>(sample.cycle()),
                  sample.name().c_str(), sample.actual_position(), unit);
      --samples;
    }
  }
  participant->delete_contained_entities();
  DomainParticipantFactory::get_instance()->delete_participant(participant);
  return samples == 0 ? EXIT_SUCCESS : EXIT_FAILURE;  // nothing came for 10 s
}
