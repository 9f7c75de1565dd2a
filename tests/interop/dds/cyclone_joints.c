/* Subscribes to the joint states that ROS 2 nodes would see, as one of them does by default, and prints the last message and
 * what its writer tells of the type.
 *
 *   cyclone_joints <domain> <min_messages> <timeout_s>
 *
 * Ends with status 0 when so many messages have arrived, with 1 when the time has passed first, with 2 on bad usage or when
 * DDS refuses to start. It stays on the loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_tool.h"
#include "ros2.h"

static const char kUsage[] = "<domain> <min_messages> <timeout_s>";

typedef sensor_msgs_msg_dds__JointState_ JointState;

static void print_reals(const char* key, const dds_sequence_double* values) {
  printf(",\"%s\":[", key);
  for (uint32_t i = 0; i < values->_length; ++i) printf("%s%.17g", i == 0 ? "" : ",", values->_buffer[i]);
  printf("]");
}

static void print_report(unsigned long messages, const JointState* last, dds_entity_t reader) {
  printf("{\"messages\":%lu", messages);
  print_user_data(reader);
  if (messages > 0) {
    printf(",\"sec\":%d,\"nanosec\":%u,\"frame_id\":\"%s\",\"name\":[", last->header_.stamp_.sec_,
           last->header_.stamp_.nanosec_, last->header_.frame_id_);
    for (uint32_t i = 0; i < last->name_._length; ++i) printf("%s\"%s\"", i == 0 ? "" : ",", last->name_._buffer[i]);
    printf("]");
    print_reals("position", &last->position_);
    print_reals("velocity", &last->velocity_);
    print_reals("effort", &last->effort_);
  }
  printf("}\n");
}

int main(int argc, char** argv) {
  if (argc != 4) {
    parse(kUsage, "", 0);
  }
  const dds_domainid_t domain = (dds_domainid_t)parse(kUsage, argv[1], 230);
  const unsigned long wanted = parse(kUsage, argv[2], 1000000);
  const dds_time_t deadline = dds_time() + DDS_SECS((int64_t)parse(kUsage, argv[3], 1000000));
  const dds_entity_t participant = join_domain(domain);
  const dds_entity_t reader = subscribe_as_ros2(participant, &sensor_msgs_msg_dds__JointState__desc, "rt/joint_states");
  static JointState last;
  const unsigned long messages = take_last(reader, &last, wanted, deadline);
  print_report(messages, &last, reader);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return messages >= wanted ? 0 : 1;
}
