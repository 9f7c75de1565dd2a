/* What a reader of driveline/v1/axis_batch has received, for the reader with Fast DDS and the one with Cyclone DDS alike:
 * how much, what was missing, and how old each cycle was. Written as C, which both are compiled as. */
#pragma once

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

enum { kLatencyBins = 1000000 }; /* of 1 us */

typedef struct Received {
  uint64_t batches;
  uint64_t lost_batches;
  uint64_t cycles;
  uint64_t skipped_cycles; /* between two that were received */
  uint64_t samples;
  uint64_t next_number;
  uint64_t next_cycle;
  int64_t longest_ns;
  uint32_t latency_us[kLatencyBins]; /* the last one: and more */
} Received;

static inline void note_batch(Received* received, uint64_t number, uint64_t samples) {
  if (received->batches > 0 && number > received->next_number) received->lost_batches += number - received->next_number;
  received->next_number = number + 1;
  received->samples += samples;
  ++received->batches;
}

static inline void note_cycle(Received* received, uint64_t cycle, int64_t wall_time_ns) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  const int64_t age_ns = (int64_t)now.tv_sec * 1000000000 + now.tv_nsec - wall_time_ns;
  const int64_t bin = age_ns < 0 ? 0 : age_ns / 1000;
  ++received->latency_us[bin < kLatencyBins ? bin : kLatencyBins - 1];
  if (age_ns > received->longest_ns) received->longest_ns = age_ns;
  if (received->cycles > 0 && cycle > received->next_cycle) received->skipped_cycles += cycle - received->next_cycle;
  received->next_cycle = cycle + 1;
  ++received->cycles;
}

/* Upper end of the bin that holds this share of all cycles, in us; by nearest rank. */
static inline uint64_t latency_us(const Received* received, uint64_t permille) {
  const uint64_t rank = (received->cycles * permille + 999) / 1000;
  uint64_t seen = 0;
  for (uint64_t bin = 0; bin < kLatencyBins; ++bin) {
    seen += received->latency_us[bin];
    if (seen >= rank) return bin + 1;
  }
  return kLatencyBins;
}

static inline double seconds_of(struct timeval time) {
  return (double)time.tv_sec + 1e-6 * (double)time.tv_usec;
}

/* One JSON document on stdout. */
static inline void print_received(const Received* received) {
  struct rusage used;
  getrusage(RUSAGE_SELF, &used);
  printf("{\"batches\":%llu,\"lost_batches\":%llu,\"cycles\":%llu,\"skipped_cycles\":%llu,\"samples\":%llu,"
         "\"latency_us\":[%llu,%llu,%llu,%.1f],\"cpu_s\":%.3f}\n",
         (unsigned long long)received->batches, (unsigned long long)received->lost_batches,
         (unsigned long long)received->cycles, (unsigned long long)received->skipped_cycles,
         (unsigned long long)received->samples, (unsigned long long)latency_us(received, 500),
         (unsigned long long)latency_us(received, 990), (unsigned long long)latency_us(received, 999),
         1e-3 * (double)received->longest_ns, seconds_of(used.ru_utime) + seconds_of(used.ru_stime));
  fflush(stdout);
}
