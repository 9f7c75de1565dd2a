// Prints the cycle of each sample of a line received by Fast DDS, for a subscriber whose settings come from the file in
// FASTRTPS_DEFAULT_PROFILES_FILE.
//
//   fast_dds_watch <domain>
//
// "axis 1232" is a sample of driveline/axis_telemetry, "status 1250" of driveline/line_status. SIGTERM ends it.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>

#include "drivelinePubSubTypes.h"

namespace {

using namespace eprosima::fastdds::dds;

template <typename Sample>
class Printer final : public DataReaderListener {
 public:
  explicit Printer(const char* word) : word_(word) {}

  void on_data_available(DataReader* reader) override {
    Sample sample;
    SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      std::printf("%s %llu\n", word_, static_cast<unsigned long long>(sample.cycle()));
      std::fflush(stdout);
    }
  }

 private:
  const char* word_;
};

bool read(DomainParticipant& participant, const char* topic, const TypeSupport& type, const DataReaderQos& qos,
          DataReaderListener& listener) {
  if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK) return false;
  auto* const described = participant.create_topic(topic, type.get_type_name(), TOPIC_QOS_DEFAULT);
  auto* const subscriber = participant.create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  return subscriber != nullptr && subscriber->create_datareader(described, qos, &listener) != nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fast_dds_watch <domain>\n", stderr);
    return 2;
  }
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  sigprocmask(SIG_BLOCK, &end, nullptr);
  Printer<driveline::telemetry::AxisTelemetry> axes("axis");
  Printer<driveline::telemetry::LineStatus> statuses("status");
  auto* const factory = DomainParticipantFactory::get_instance();
  factory->load_profiles();
  auto* const participant =
      factory->create_participant(static_cast<unsigned>(std::atoi(argv[1])), factory->get_default_participant_qos());
  if (participant == nullptr) return 1;
  DataReaderQos reliable;
  reliable.reliability().kind = RELIABLE_RELIABILITY_QOS;
  reliable.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
  const TypeSupport axis(new driveline::telemetry::AxisTelemetryPubSubType);
  const TypeSupport status(new driveline::telemetry::LineStatusPubSubType);
  if (!read(*participant, "driveline/axis_telemetry", axis, DataReaderQos{}, axes)) return 1;
  if (!read(*participant, "driveline/line_status", status, reliable, statuses)) return 1;
  int number = 0;
  sigwait(&end, &number);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return 0;
}
