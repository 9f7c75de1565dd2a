/* Watches over a line with Cyclone DDS: asks for its status within a deadline, and for its liveliness.
 *
 *   cyclone_watch <domain> <seconds>
 *
 * Prints one JSON document: statuses that came, deadlines that were missed, writers
 * alive in the end. Ends with status 0, with 2 on bad usage or when DDS refuses to start. It stays on the loopback interface
 * unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_tool.h"
#include "driveline.h"

static const char kUsage[] = "<domain> <seconds>";

static dds_entity_t create_reader(dds_entity_t participant) {
  const dds_entity_t topic = checked(
      dds_create_topic(participant, &driveline_telemetry_LineStatus_desc, "driveline/line_status", NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_deadline(qos, DDS_MSECS(1500));
  dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(1500));
  const dds_entity_t reader = checked(dds_create_reader(participant, topic, qos, NULL), "reader");
  dds_delete_qos(qos);
  return reader;
}

int main(int argc, char** argv) {
  if (argc != 3) {
    parse(kUsage, "", 0);
  }
  const dds_domainid_t domain = (dds_domainid_t)parse(kUsage, argv[1], 230);
  const dds_time_t end = dds_time() + DDS_SECS((int64_t)parse(kUsage, argv[2], 1000000));
  const dds_entity_t participant = join_domain(domain);
  const dds_entity_t reader = create_reader(participant);
  static driveline_telemetry_LineStatus status;
  void* sample[1] = {&status};
  dds_sample_info_t info;
  unsigned long statuses = 0;
  while (dds_time() < end) {
    dds_sleepfor(DDS_MSECS(10));
    while (dds_take(reader, sample, &info, 1, 1) > 0) statuses += info.valid_data ? 1 : 0;
  }
  dds_requested_deadline_missed_status_t missed = {0};
  dds_liveliness_changed_status_t liveliness = {0};
  dds_get_requested_deadline_missed_status(reader, &missed);
  dds_get_liveliness_changed_status(reader, &liveliness);
  printf("{\"statuses\":%lu,\"deadlines_missed\":%u,\"alive\":%u}\n", statuses, missed.total_count,
         liveliness.alive_count);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return 0;
}
