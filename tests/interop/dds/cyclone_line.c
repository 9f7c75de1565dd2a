/* Subscribes to what changes now and then on a drive line with Cyclone DDS, slaves, topology, states of the axes and
 * statistics of the cycle, and prints what it received as one JSON document, with every field of the types.
 *
 *   cyclone_line <domain> <min_statistics> <timeout_s>
 *
 * Ends with status 0 as soon as a topology, all slaves that it counts and <min_statistics> statistics have arrived, with
 * 1 when <timeout_s> passed first, with 2 on bad usage or when DDS refuses to start. It stays on the loopback interface
 * unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_tool.h"
#include "driveline.h"

static const char kUsage[] = "<domain> <min_statistics> <timeout_s>";

enum { kMaxSlaves = 64, kMaxAxes = 64 };

typedef driveline_telemetry_Slave Slave;
typedef driveline_telemetry_Topology Topology;
typedef driveline_telemetry_AxisStatus AxisStatus;
typedef driveline_telemetry_CycleStatistics CycleStatistics;

static Slave slaves[kMaxSlaves];
static AxisStatus axes[kMaxAxes];
static bool axis_seen[kMaxAxes];
static unsigned long axis_messages, slave_messages, topologies, statistics;
static Topology topology;
static CycleStatistics newest;

static const char* const kSlaveStates[] = {"UNKNOWN", "INIT", "PRE_OP", "BOOTSTRAP", "SAFE_OP", "OP"};

static const char* const kStates[] = {"NOT_READY_TO_SWITCH_ON", "SWITCH_ON_DISABLED", "READY_TO_SWITCH_ON",
                                      "SWITCHED_ON",            "OPERATION_ENABLED",  "QUICK_STOP_ACTIVE",
                                      "FAULT_REACTION_ACTIVE",  "FAULT",              "UNAVAILABLE"};
static const char* const kPlcopenStates[] = {"NONE",     "DISABLED",        "STANDSTILL",        "HOMING",
                                             "STOPPING", "DISCRETE_MOTION", "CONTINUOUS_MOTION", "SYNCHRONIZED_MOTION",
                                             "ERROR_STOP"};
static const char* const kHomed[] = {"UNKNOWN", "NO", "YES"};

static dds_entity_t create_reader(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* topic_name) {
  return subscribe(participant, type, topic_name, DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL, 8);
}

static void take_slaves(dds_entity_t reader) {
  Slave next = {0};
  void* sample[1] = {&next};
  dds_sample_info_t info;
  while (dds_take(reader, sample, &info, 1, 1) > 0) {
    if (!info.valid_data || next.position >= kMaxSlaves) continue;
    slaves[next.position] = next;
    ++slave_messages;
  }
}

static void take_axes(dds_entity_t reader) {
  AxisStatus next = {0};
  void* sample[1] = {&next};
  dds_sample_info_t info;
  while (dds_take(reader, sample, &info, 1, 1) > 0) {
    if (!info.valid_data || next.axis >= kMaxAxes) continue;
    axes[next.axis] = next;
    axis_seen[next.axis] = true;
    ++axis_messages;
  }
}

/* One message of a topic with one instance; a writer that goes sends one without data, which must not replace it. */
static bool take_one(dds_entity_t reader, void* message, bool* valid) {
  void* sample[1] = {message};
  dds_sample_info_t info;
  if (dds_take(reader, sample, &info, 1, 1) <= 0) return false;
  *valid = info.valid_data;
  return true;
}

static void take_topology(dds_entity_t reader) {
  static Topology next;
  bool valid = false;
  while (take_one(reader, &next, &valid)) {
    if (!valid) continue;
    const Topology before = topology;
    topology = next;
    next = before; /* its memory is used again */
    ++topologies;
  }
}

static void take_statistics(dds_entity_t reader) {
  CycleStatistics next;
  bool valid = false;
  while (take_one(reader, &next, &valid)) {
    if (!valid) continue;
    newest = next;
    ++statistics;
  }
}

static const char* truth(bool value) {
  return value ? "true" : "false";
}

static void print_ports(const Slave* slave) {
  printf(",\"ports\":[");
  for (int i = 0; i < 4; ++i) {
    const driveline_telemetry_SlavePort* port = &slave->ports[i];
    printf("%s{\"link\":%s,\"open\":%s,\"invalid_frames\":%u,\"receive_errors\":%u,\"forwarded_errors\":%u,"
           "\"lost_links\":%u}",
           i == 0 ? "" : ",", truth(port->link), truth(port->open), port->invalid_frames, port->receive_errors,
           port->forwarded_errors, port->lost_links);
  }
  printf("]");
}

static void print_slave(const Slave* slave) {
  printf("{\"position\":%u,\"name\":", slave->position);
  print_string(slave->name);
  printf(",\"device\":");
  print_string(slave->device);
  printf(",\"vendor_id\":%u,\"product_code\":%u,\"revision\":%u,\"serial_number\":%u,\"station_address\":%u,\"alias\":%u",
         slave->vendor_id, slave->product_code, slave->revision, slave->serial_number, slave->station_address,
         slave->alias);
  printf(",\"hot_connect\":%s,\"answers\":%s,\"wall_time_ns\":%lld,\"state\":\"%s\",\"error\":%s,\"al_status_code\":%u",
         truth(slave->hot_connect), truth(slave->answers), (long long)slave->wall_time_ns,
         (unsigned)slave->state < 6 ? kSlaveStates[slave->state] : "?", truth(slave->error), slave->al_status_code);
  printf(",\"al_status_text\":");
  print_string(slave->al_status_text);
  print_ports(slave);
  printf(",\"processing_unit_errors\":%u,\"pdi_errors\":%u,\"dc_clock\":%s,\"dc_reference\":%s,\"dc_delay_ns\":%lld,"
         "\"dc_difference_max_ns\":%lld,\"dc_sync0_cycle_ns\":%lld}",
         slave->processing_unit_errors, slave->pdi_errors, truth(slave->dc_clock), truth(slave->dc_reference),
         (long long)slave->dc_delay_ns, (long long)slave->dc_difference_max_ns, (long long)slave->dc_sync0_cycle_ns);
}

static const char* word(const char* const* words, unsigned count, unsigned number) {
  return number < count ? words[number] : "?";
}

static void print_axis(const AxisStatus* axis) {
  printf("{\"axis\":%u,\"name\":", axis->axis);
  print_string(axis->name);
  printf(",\"kind\":\"%s\",\"cycle\":%llu,\"time_ns\":%lld,\"wall_time_ns\":%lld,\"state\":\"%s\",\"plcopen_state\":\"%s\"",
         axis->kind == driveline_telemetry_AXIS_LINEAR ? "LINEAR" : "ROTARY", (unsigned long long)axis->cycle,
         (long long)axis->time_ns, (long long)axis->wall_time_ns, word(kStates, 9, (unsigned)axis->state),
         word(kPlcopenStates, 9, (unsigned)axis->plcopen_state));
  printf(",\"mode\":%d,\"error_code\":%u,\"owner\":", axis->mode, axis->error_code);
  print_string(axis->owner);
  printf(",\"homed\":\"%s\",\"digital_inputs_mapped\":%s,\"digital_inputs\":%u}",
         word(kHomed, 3, (unsigned)axis->homed), truth(axis->digital_inputs_mapped), axis->digital_inputs);
}

static void print_topology_ports(const char* name, const driveline_telemetry_TopologyPort* ports, uint32_t count) {
  printf(",\"%s\":[", name);
  for (uint32_t i = 0; i < count; ++i) printf("%s[%u,%u]", i == 0 ? "" : ",", ports[i].position, ports[i].port);
  printf("]");
}

/* Nodes as [position, parent, port of the parent, own port, depth]. */
static void print_topology(void) {
  printf("{\"slaves\":%u,\"nodes\":[", topology.slaves);
  for (uint32_t i = 0; i < topology.nodes._length; ++i) {
    const driveline_telemetry_TopologyNode* node = &topology.nodes._buffer[i];
    printf("%s[%u,%d,%u,%u,%u]", i == 0 ? "" : ",", node->position, node->parent, node->parent_port, node->entry_port,
           node->depth);
  }
  printf("]");
  print_topology_ports("ring_end", topology.ring_end._buffer, topology.ring_end._length);
  print_topology_ports("silent_ports", topology.silent_ports._buffer, topology.silent_ports._length);
  printf("}");
}

static void print_distribution(const char* name, const driveline_telemetry_TimeDistribution* times) {
  printf(",\"%s\":{\"count\":%llu,\"p50_ns\":%lld,\"p90_ns\":%lld,\"p99_ns\":%lld,\"p999_ns\":%lld,\"max_ns\":%lld}", name,
         (unsigned long long)times->count, (long long)times->p50_ns, (long long)times->p90_ns, (long long)times->p99_ns,
         (long long)times->p999_ns, (long long)times->max_ns);
}

static void print_interval(const char* name, const driveline_telemetry_CycleInterval* interval) {
  printf(",\"%s\":{\"duration_ns\":%lld,\"cycles\":%llu,\"missed_periods\":%llu,\"wkc_errors\":%llu,\"lost_frames\":%llu",
         name, (long long)interval->duration_ns, (unsigned long long)interval->cycles,
         (unsigned long long)interval->missed_periods, (unsigned long long)interval->wkc_errors,
         (unsigned long long)interval->lost_frames);
  print_distribution("wake_latency", &interval->wake_latency);
  print_distribution("cycle_cost", &interval->cycle_cost);
  print_distribution("jitter", &interval->jitter);
  print_distribution("round_trip", &interval->round_trip);
  print_distribution("dc_difference", &interval->dc_difference);
  printf("}");
}

static void print_statistics(void) {
  printf("{\"number\":%llu,\"cycle\":%llu,\"time_ns\":%lld,\"wall_time_ns\":%lld,\"cycle_period_ns\":%lld,"
         "\"dc_locked\":%s,\"dc_difference_ns\":%lld",
         (unsigned long long)newest.number, (unsigned long long)newest.cycle, (long long)newest.time_ns,
         (long long)newest.wall_time_ns, (long long)newest.cycle_period_ns, truth(newest.dc_locked),
         (long long)newest.dc_difference_ns);
  print_interval("last", &newest.last);
  print_interval("total", &newest.total);
  printf("}");
}

static bool all_slaves(void) {
  for (unsigned i = 0; i < topology.slaves; ++i) {
    if (i >= kMaxSlaves || slaves[i].wall_time_ns == 0) return false;
  }
  return topologies > 0;
}

static void print_report(void) {
  printf("{\"slave_messages\":%lu,\"topologies\":%lu,\"statistics_messages\":%lu,\"slaves\":[", slave_messages,
         topologies, statistics);
  for (unsigned i = 0, printed = 0; i < kMaxSlaves; ++i) {
    if (slaves[i].wall_time_ns == 0) continue;
    if (printed++ > 0) putchar(',');
    print_slave(&slaves[i]);
  }
  printf("],\"axis_messages\":%lu,\"axes\":[", axis_messages);
  for (unsigned i = 0, printed = 0; i < kMaxAxes; ++i) {
    if (!axis_seen[i]) continue;
    if (printed++ > 0) putchar(',');
    print_axis(&axes[i]);
  }
  printf("],\"topology\":");
  if (topologies > 0) print_topology();
  else printf("null");
  printf(",\"statistics\":");
  if (statistics > 0) print_statistics();
  else printf("null");
  printf("}\n");
}

int main(int argc, char** argv) {
  if (argc != 4) {
    parse(kUsage, "", 0);
  }
  const dds_domainid_t domain = (dds_domainid_t)parse(kUsage, argv[1], 230);
  const unsigned long min_statistics = parse(kUsage, argv[2], 1000000000);
  const dds_time_t deadline = dds_time() + DDS_SECS((int64_t)parse(kUsage, argv[3], 1000000));
  const dds_entity_t participant = join_domain(domain);
  const dds_entity_t slave_reader = create_reader(participant, &driveline_telemetry_Slave_desc, "driveline/v1/slave");
  const dds_entity_t topology_reader =
      create_reader(participant, &driveline_telemetry_Topology_desc, "driveline/v1/topology");
  const dds_entity_t statistics_reader =
      create_reader(participant, &driveline_telemetry_CycleStatistics_desc, "driveline/v1/cycle_statistics");
  const dds_entity_t axis_reader =
      create_reader(participant, &driveline_telemetry_AxisStatus_desc, "driveline/v1/axis_state");
  bool complete = false;
  while (!complete && dds_time() < deadline) {
    dds_sleepfor(DDS_MSECS(20));
    take_slaves(slave_reader);
    take_axes(axis_reader);
    take_topology(topology_reader);
    take_statistics(statistics_reader);
    complete = all_slaves() && statistics >= min_statistics;
  }
  /* They are reliable, but on a way of their own. */
  for (int i = 0; i < 5; ++i) {
    dds_sleepfor(DDS_MSECS(50));
    take_axes(axis_reader);
  }
  print_report();
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return complete ? 0 : 1;
}
