/* Subscribes to the diagnostics that ROS 2 nodes would see, as one of them does by default, and prints the last message and
 * what its writer tells of the type.
 *
 *   cyclone_diagnostics <domain> <min_messages> <timeout_s>
 *
 * Ends with status 0 when so many messages have arrived, with 1 when the time has passed first, with 2 on bad usage or when
 * DDS refuses to start. It stays on the loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <stdio.h>

#include "cyclone_tool.h"
#include "ros2.h"

static diagnostic_msgs_msg_dds__DiagnosticArray_ last;

static void print_status(const diagnostic_msgs_msg_dds__DiagnosticStatus_* status) {
  printf("{\"level\":%u,\"name\":", status->level_);
  print_string(status->name_);
  printf(",\"message\":");
  print_string(status->message_);
  printf(",\"hardware_id\":");
  print_string(status->hardware_id_);
  printf(",\"values\":{");
  for (uint32_t i = 0; i < status->values_._length; ++i) {
    if (i > 0) putchar(',');
    print_string(status->values_._buffer[i].key_);
    putchar(':');
    print_string(status->values_._buffer[i].value_);
  }
  printf("}}");
}

static void print_last(void) {
  printf(",\"sec\":%d,\"nanosec\":%u,\"frame_id\":\"%s\",\"status\":[", last.header_.stamp_.sec_,
         last.header_.stamp_.nanosec_, last.header_.frame_id_);
  for (uint32_t i = 0; i < last.status_._length; ++i) {
    if (i > 0) putchar(',');
    print_status(&last.status_._buffer[i]);
  }
  printf("]");
}

int main(int argc, char** argv) {
  return read_as_ros2(argc, argv, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics", &last, print_last);
}
