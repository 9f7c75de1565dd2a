/* Subscribes to the batches and events of a drive line with Cyclone DDS and prints what it received as one JSON document.
 *
 *   cyclone_batches <domain> <min_batches> <timeout_s>
 *
 * Ends with status 0 as soon as <min_batches> batches have arrived, with 1 when <timeout_s> passed first, with 2 on bad
 * usage or when DDS refuses to start. It stays on the loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_tool.h"
#include "driveline.h"

static const char kUsage[] = "<domain> <min_batches> <timeout_s>";

enum { kMaxEvents = 64 };

typedef driveline_telemetry_AxisBatch AxisBatch;
typedef driveline_telemetry_Event Event;

static unsigned long batches, lost_batches, cycles, skipped_cycles, samples;
static uint64_t next_number, next_cycle;
static AxisBatch last;
static Event events[kMaxEvents];
static unsigned event_count;

static const char* const kSeverities[] = {"PROGRESS", "NOTICE", "FAULT", "FAILURE"};

static void count_batch(const AxisBatch* batch) {
  if (batches > 0 && batch->number > next_number) lost_batches += batch->number - next_number;
  next_number = batch->number + 1;
  for (uint32_t i = 0; i < batch->cycles._length; ++i) {
    const uint64_t cycle = batch->cycles._buffer[i].cycle;
    if (cycles > 0 && cycle > next_cycle) skipped_cycles += cycle - next_cycle;
    next_cycle = cycle + 1;
    ++cycles;
  }
  samples += batch->samples._length;
  ++batches;
}

static void take_batches(dds_entity_t reader) {
  static AxisBatch next;
  void* sample[1] = {&next};
  dds_sample_info_t info;
  while (dds_take(reader, sample, &info, 1, 1) > 0) {
    if (info.valid_data) {
      count_batch(&next);
      const AxisBatch before = last;
      last = next;
      next = before; /* its memory is used again */
    }
  }
}

static void take_events(dds_entity_t reader) {
  void* sample[1];
  dds_sample_info_t info;
  while (event_count < kMaxEvents) {
    sample[0] = &events[event_count];
    if (dds_take(reader, sample, &info, 1, 1) <= 0) break;
    if (info.valid_data) ++event_count;
  }
}

static void print_number(double value) {
  if (isfinite(value)) {
    printf(",%.17g", value);
  } else {
    printf(",null"); /* JSON knows no NaN */
  }
}

/* Cycles as [cycle, time, wall time], samples as [cycle index, axis, control word, status word, mode, state, values...]. */
static void print_last(void) {
  printf(",\"last\":{\"number\":%llu,\"cycle_period_ns\":%lld,\"axes\":%u,\"cycles\":[", (unsigned long long)last.number,
         (long long)last.cycle_period_ns, last.axes);
  for (uint32_t i = 0; i < last.cycles._length; ++i) {
    const driveline_telemetry_CycleTime* time = &last.cycles._buffer[i];
    printf("%s[%llu,%lld,%lld]", i == 0 ? "" : ",", (unsigned long long)time->cycle, (long long)time->time_ns,
           (long long)time->wall_time_ns);
  }
  printf("],\"samples\":[");
  for (uint32_t i = 0; i < last.samples._length; ++i) {
    const driveline_telemetry_AxisValues* values = &last.samples._buffer[i];
    printf("%s[%u,%u,%u,%u,%d,%u", i == 0 ? "" : ",", values->cycle_index, values->axis, values->control_word,
           values->status_word, values->mode, (unsigned)values->state);
    print_number(values->target_position);
    print_number(values->actual_position);
    print_number(values->target_velocity);
    print_number(values->actual_velocity);
    print_number(values->target_torque);
    print_number(values->actual_torque);
    print_number(values->following_error);
    print_number(values->drive_following_error);
    print_number(values->demand_position);
    print_number(values->demand_velocity);
    print_number(values->demand_torque);
    printf(",%u,%u]", values->digital_inputs, (unsigned)values->plcopen_state);
  }
  printf("]}");
}

static void print_report(void) {
  printf("{\"batches\":%lu,\"lost_batches\":%lu,\"cycles\":%lu,\"skipped_cycles\":%lu,\"samples\":%lu", batches,
         lost_batches, cycles, skipped_cycles, samples);
  if (batches > 0) print_last();
  printf(",\"events\":[");
  for (unsigned i = 0; i < event_count; ++i) {
    printf("%s{\"number\":%llu,\"wall_time_ns\":%lld,\"severity\":\"%s\",\"text\":", i == 0 ? "" : ",",
           (unsigned long long)events[i].number, (long long)events[i].wall_time_ns,
           (unsigned)events[i].severity < 4 ? kSeverities[events[i].severity] : "?");
    print_string(events[i].text);
    printf("}");
  }
  printf("]}\n");
}

int main(int argc, char** argv) {
  if (argc != 4) {
    parse(kUsage, "", 0);
  }
  const dds_domainid_t domain = (dds_domainid_t)parse(kUsage, argv[1], 230);
  const unsigned long min_batches = parse(kUsage, argv[2], 1000000000);
  const dds_time_t deadline = dds_time() + DDS_SECS((int64_t)parse(kUsage, argv[3], 1000000));
  const dds_entity_t participant = join_domain(domain);
  const dds_entity_t batch_reader =
      subscribe(participant, &driveline_telemetry_AxisBatch_desc, "driveline/v1/axis_batch",
                DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE, 256);
  const dds_entity_t event_reader = subscribe(participant, &driveline_telemetry_Event_desc, "driveline/v1/event",
                                              DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL, kMaxEvents);
  const dds_entity_t waitset = checked(dds_create_waitset(participant), "waitset");
  checked(dds_waitset_attach(waitset, checked(dds_create_readcondition(batch_reader, DDS_ANY_STATE), "condition"), 0),
          "waitset");
  while (batches < min_batches && dds_time() < deadline) {
    dds_waitset_wait_until(waitset, NULL, 0, deadline);
    take_batches(batch_reader);
  }
  /* They are reliable, but on a way of their own. */
  for (int i = 0; i < 50 && event_count == 0; ++i) {
    dds_sleepfor(DDS_MSECS(100));
    take_events(event_reader);
  }
  dds_sleepfor(DDS_MSECS(100));
  take_events(event_reader);
  print_report();
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return batches >= min_batches ? 0 : 1;
}
