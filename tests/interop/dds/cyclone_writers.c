/* Looks at the writers of a domain with Cyclone DDS, and reads the status of a line in a partition.
 *
 *   cyclone_writers <domain> <seconds> [<partition>]
 *
 * Waits until a status has come, for so long at most. Prints one JSON document: how many came, and topic,
 * reliability, durability, deadline (ms; -1: none) and partition of all writers that it has found. Ends with status 0, with 2 on bad
 * usage or when DDS refuses to start. It stays on the loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_tool.h"
#include "driveline.h"

static const char kUsage[] = "<domain> <seconds> [<partition>]";

enum { kMaxWriters = 64 };

static dds_entity_t create_reader(dds_entity_t participant, const char* partition) {
  const dds_entity_t topic = checked(
      dds_create_topic(participant, &driveline_telemetry_LineStatus_desc, "driveline/line_status", NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  if (partition != NULL) dds_qset_partition1(qos, partition);
  const dds_entity_t subscriber = checked(dds_create_subscriber(participant, qos, NULL), "subscriber");
  dds_delete_qos(qos);
  qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_entity_t reader = checked(dds_create_reader(subscriber, topic, qos, NULL), "reader");
  dds_delete_qos(qos);
  return reader;
}

static void print_writer(const dds_builtintopic_endpoint_t* writer) {
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_duration_t deadline = DDS_INFINITY;
  uint32_t partitions = 0;
  char** partition = NULL;
  dds_qget_reliability(writer->qos, &reliability, NULL);
  dds_qget_durability(writer->qos, &durability);
  dds_qget_deadline(writer->qos, &deadline);
  dds_qget_partition(writer->qos, &partitions, &partition);
  printf("{\"topic\":");
  print_string(writer->topic_name);
  printf(",\"reliable\":%s,\"durability\":%d,\"deadline_ms\":%lld,\"partition\":",
         reliability == DDS_RELIABILITY_RELIABLE ? "true" : "false", (int)durability,
         deadline == DDS_INFINITY ? -1LL : (long long)(deadline / 1000000));
  print_string(partitions > 0 ? partition[0] : "");
  printf("}");
  for (uint32_t i = 0; i < partitions; ++i) dds_free(partition[i]);
  dds_free(partition);
}

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    parse(kUsage, "", 0);
  }
  const dds_domainid_t domain = (dds_domainid_t)parse(kUsage, argv[1], 230);
  const dds_time_t end = dds_time() + DDS_SECS((int64_t)parse(kUsage, argv[2], 1000000));
  const dds_entity_t participant = join_domain(domain);
  const dds_entity_t publications =
      checked(dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL), "reader of writers");
  const dds_entity_t reader = create_reader(participant, argc == 4 ? argv[3] : NULL);
  static driveline_telemetry_LineStatus status;
  void* sample[1] = {&status};
  dds_sample_info_t info[kMaxWriters];
  unsigned long statuses = 0;
  while (dds_time() < end && statuses == 0) {
    dds_sleepfor(DDS_MSECS(10));
    while (dds_take(reader, sample, info, 1, 1) > 0) statuses += info[0].valid_data ? 1 : 0;
  }
  dds_sleepfor(DDS_SECS(1)); /* writers that come behind that of the status */
  void* writers[kMaxWriters] = {0};
  const dds_return_t count = dds_read(publications, writers, info, kMaxWriters, kMaxWriters);
  printf("{\"statuses\":%lu,\"writers\":[", statuses);
  for (dds_return_t i = 0; i < count; ++i) {
    if (i > 0) printf(",");
    print_writer(writers[i]);
  }
  printf("]}\n");
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return 0;
}
