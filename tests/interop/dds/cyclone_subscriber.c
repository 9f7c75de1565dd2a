/* Subscribes to the telemetry of a drive line with Cyclone DDS and prints what it received as one JSON document.
 *
 *   cyclone_subscriber <domain> <min_samples> <timeout_s> [<axis topic> <status topic>]
 *
 * Ends with status 0 as soon as <min_samples> line statuses and <min_samples> samples of every axis the line status
 * announces have arrived, with 1 when <timeout_s> passed first, with 2 on bad usage or when DDS refuses to start.
 * It stays on the loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cyclone_tool.h"
#include "driveline.h"

static const char kUsage[] = "<domain> <min_samples> <timeout_s> [<axis topic> <status topic>]";

enum { kMaxAxes = 256, kBatch = 64 };

typedef driveline_telemetry_AxisTelemetry AxisTelemetry;
typedef driveline_telemetry_LineStatus LineStatus;

typedef struct {
  unsigned long samples;
  unsigned long backward; /* samples whose cycle is not above that of the sample before */
  uint64_t first_cycle;
  double min_position, max_position, max_following_error;
  AxisTelemetry last;
} Axis;

static Axis axes[kMaxAxes];
static unsigned long unknown_axes; /* samples of axes beyond kMaxAxes */
static unsigned long statuses;
static LineStatus last_status, next_status;

static const char* const kAxisStates[] = {"NOT_READY_TO_SWITCH_ON",
                                          "SWITCH_ON_DISABLED",
                                          "READY_TO_SWITCH_ON",
                                          "SWITCHED_ON",
                                          "OPERATION_ENABLED",
                                          "QUICK_STOP_ACTIVE",
                                          "FAULT_REACTION_ACTIVE",
                                          "FAULT",
                                          "UNAVAILABLE"};
static const char* const kLineStates[] = {"DOWN", "INIT", "PRE_OP", "SAFE_OP", "OP"};
static const char* const kAxisKinds[] = {"rotary", "linear"};

static void count_axis(const AxisTelemetry* sample) {
  if (sample->axis >= kMaxAxes) {
    ++unknown_axes;
    return;
  }
  Axis* axis = &axes[sample->axis];
  if (axis->samples == 0) {
    axis->first_cycle = sample->cycle;
    axis->min_position = axis->max_position = sample->actual_position;
  } else if (sample->cycle <= axis->last.cycle) {
    ++axis->backward;
  }
  ++axis->samples;
  axis->min_position = fmin(axis->min_position, sample->actual_position);
  axis->max_position = fmax(axis->max_position, sample->actual_position);
  axis->max_following_error = fmax(axis->max_following_error, fabs(sample->following_error));
  axis->last = *sample;
}

static void take_axes(dds_entity_t reader) {
  void* samples[kBatch] = {NULL}; /* NULL asks for a loan */
  dds_sample_info_t infos[kBatch];
  const int taken = dds_take(reader, samples, infos, kBatch, kBatch);
  for (int i = 0; i < taken; ++i) {
    if (infos[i].valid_data) {
      count_axis(samples[i]);
    }
  }
  if (taken > 0) {
    dds_return_loan(reader, samples, taken);
  }
}

/* Reads into samples of our own, because the last one is needed after a loan would have ended. */
static void take_status(dds_entity_t reader) {
  void* samples[1] = {&next_status};
  dds_sample_info_t info;
  while (dds_take(reader, samples, &info, 1, 1) > 0) {
    if (info.valid_data) { /* else only news of the writer, such as that it left */
      const LineStatus before = last_status;
      last_status = next_status;
      next_status = before; /* its memory is used again */
      ++statuses;
    }
  }
}

static bool satisfied(unsigned long min_samples) {
  if (statuses == 0 || statuses < min_samples) {
    return false;
  }
  for (unsigned i = 0; i < last_status.axes && i < kMaxAxes; ++i) {
    if (axes[i].samples < min_samples) {
      return false;
    }
  }
  return true;
}

static const char* name_of(const char* const* names, size_t count, uint32_t value) {
  return value < count ? names[value] : "?";
}
#define NAME_OF(names, value) name_of(names, sizeof(names) / sizeof((names)[0]), (uint32_t)(value))

static void print_double(const char* key, double value) {
  if (isfinite(value)) {
    printf(",\"%s\":%.17g", key, value);
  } else {
    printf(",\"%s\":null", key); /* JSON knows no NaN */
  }
}

static void print_axis(const Axis* axis) {
  const AxisTelemetry* last = &axis->last;
  printf("{\"axis\":%u,\"name\":", last->axis);
  print_string(last->name);
  printf(",\"kind\":\"%s\",\"samples\":%lu,\"backward\":%lu,\"first_cycle\":%llu", NAME_OF(kAxisKinds, last->kind),
         axis->samples, axis->backward, (unsigned long long)axis->first_cycle);
  print_double("actual_position_min", axis->min_position);
  print_double("actual_position_max", axis->max_position);
  print_double("following_error_max", axis->max_following_error);
  printf(
      ",\"last\":{\"cycle\":%llu,\"time_ns\":%lld,\"control_word\":%u,\"status_word\":%u,\"mode\":%d,\"state\":\"%s\"",
      (unsigned long long)last->cycle, (long long)last->time_ns, last->control_word, last->status_word, last->mode,
      NAME_OF(kAxisStates, last->state));
  print_double("target_position", last->target_position);
  print_double("actual_position", last->actual_position);
  print_double("target_velocity", last->target_velocity);
  print_double("actual_velocity", last->actual_velocity);
  print_double("target_torque", last->target_torque);
  print_double("actual_torque", last->actual_torque);
  print_double("following_error", last->following_error);
  printf("}}");
}

static void print_percentiles(const char* key, const driveline_telemetry_Percentiles* values) {
  printf(",\"%s\":{\"p50\":%lld,\"p99\":%lld,\"max\":%lld}", key, (long long)values->p50_ns, (long long)values->p99_ns,
         (long long)values->max_ns);
}

static void print_status(const LineStatus* status) {
  printf("{\"name\":");
  print_string(status->name);
  printf(",\"state\":\"%s\",\"axes\":%u,\"cycle_period_ns\":%lld,\"cycle\":%llu,\"time_ns\":%lld",
         NAME_OF(kLineStates, status->state), status->axes, (long long)status->cycle_period_ns,
         (unsigned long long)status->cycle, (long long)status->time_ns);
  printf(",\"dc_locked\":%s,\"dc_difference_ns\":%lld", status->dc_locked ? "true" : "false",
         (long long)status->dc_difference_ns);
  printf(",\"cycles\":%llu,\"missed_periods\":%llu,\"wkc_errors\":%llu,\"lost_frames\":%llu",
         (unsigned long long)status->cycles, (unsigned long long)status->missed_periods,
         (unsigned long long)status->wkc_errors, (unsigned long long)status->lost_frames);
  print_percentiles("wake_latency_ns", &status->wake_latency);
  print_percentiles("cycle_cost_ns", &status->cycle_cost);
  printf(",\"telemetry\":{\"published\":%llu,\"dropped\":%llu},\"faults\":[",
         (unsigned long long)status->telemetry_published, (unsigned long long)status->telemetry_dropped);
  for (uint32_t i = 0; i < status->faults._length; ++i) {
    printf(i == 0 ? "" : ",");
    print_string(status->faults._buffer[i]);
  }
  printf("]}");
}

static void print_report(bool complete) {
  printf("{\"complete\":%s,\"unknown_axes\":%lu,\"axes\":[", complete ? "true" : "false", unknown_axes);
  bool first = true;
  for (unsigned i = 0; i < kMaxAxes; ++i) {
    if (axes[i].samples != 0) {
      printf(first ? "" : ",");
      print_axis(&axes[i]);
      first = false;
    }
  }
  printf("],\"line_statuses\":%lu,\"line_status\":", statuses);
  if (statuses == 0) {
    printf("null");
  } else {
    print_status(&last_status);
  }
  printf("}\n");
}

int main(int argc, char** argv) {
  if (argc != 4 && argc != 6) {
    parse(kUsage, "", 0);
  }
  const dds_domainid_t domain = (dds_domainid_t)parse(kUsage, argv[1], 230);
  const unsigned long min_samples = parse(kUsage, argv[2], 1000000000);
  const unsigned long timeout_s = parse(kUsage, argv[3], 1000000);
  const char* axis_topic = argc == 6 ? argv[4] : "driveline/axis_telemetry";
  const char* status_topic = argc == 6 ? argv[5] : "driveline/line_status";

  const dds_entity_t participant = join_domain(domain);
  const dds_entity_t axis_reader = subscribe(participant, &driveline_telemetry_AxisTelemetry_desc, axis_topic,
                                             DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE, 256);
  const dds_entity_t status_reader = subscribe(participant, &driveline_telemetry_LineStatus_desc, status_topic,
                                               DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL, 16);
  const dds_entity_t waitset = checked(dds_create_waitset(participant), "waitset");
  const dds_entity_t axis_data = checked(dds_create_readcondition(axis_reader, DDS_ANY_STATE), "condition");
  const dds_entity_t status_data = checked(dds_create_readcondition(status_reader, DDS_ANY_STATE), "condition");
  checked(dds_waitset_attach(waitset, axis_data, 0), "waitset");
  checked(dds_waitset_attach(waitset, status_data, 0), "waitset");

  const dds_time_t deadline = dds_time() + DDS_SECS((int64_t)timeout_s);
  bool complete = satisfied(min_samples);
  while (!complete && dds_time() < deadline) {
    dds_waitset_wait_until(waitset, NULL, 0, deadline);
    take_axes(axis_reader);
    take_status(status_reader);
    complete = satisfied(min_samples);
  }
  print_report(complete);
  dds_sample_free(&last_status, &driveline_telemetry_LineStatus_desc, DDS_FREE_CONTENTS);
  dds_sample_free(&next_status, &driveline_telemetry_LineStatus_desc, DDS_FREE_CONTENTS);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return complete ? 0 : 1;
}
