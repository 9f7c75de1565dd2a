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

#include "cyclone_tool.h"
#include "ros2.h"

static sensor_msgs_msg_dds__JointState_ last;

static void print_reals(const char* key, const dds_sequence_double* values) {
  printf(",\"%s\":[", key);
  for (uint32_t i = 0; i < values->_length; ++i) printf("%s%.17g", i == 0 ? "" : ",", values->_buffer[i]);
  printf("]");
}

static void print_last(void) {
  printf(",\"sec\":%d,\"nanosec\":%u,\"frame_id\":\"%s\",\"name\":[", last.header_.stamp_.sec_,
         last.header_.stamp_.nanosec_, last.header_.frame_id_);
  for (uint32_t i = 0; i < last.name_._length; ++i) printf("%s\"%s\"", i == 0 ? "" : ",", last.name_._buffer[i]);
  printf("]");
  print_reals("position", &last.position_);
  print_reals("velocity", &last.velocity_);
  print_reals("effort", &last.effort_);
}

int main(int argc, char** argv) {
  return read_as_ros2(argc, argv, &sensor_msgs_msg_dds__JointState__desc, "rt/joint_states", &last, print_last);
}
