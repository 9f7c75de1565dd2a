/* Reads the batches of a line on the loopback interface with Cyclone DDS until SIGTERM, then prints what it has received.
 *
 *   cyclone_reader DOMAIN
 */
#include <dds/dds.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>

#include "driveline.h"
#include "received.h"

typedef driveline_telemetry_AxisBatch AxisBatch;

static const char kLoopbackOnly[] =
    "<Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>15</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain>";

static Received received;

static dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "cyclone_reader: cannot create the %s: %s\n", what, dds_strretcode(-entity));
    exit(2);
  }
  return entity;
}

static void on_data(dds_entity_t reader, void* unused) {
  (void)unused;
  void* samples[1] = {NULL}; /* lent by Cyclone DDS */
  dds_sample_info_t info;
  while (dds_take(reader, samples, &info, 1, 1) > 0) {
    const AxisBatch* batch = samples[0];
    if (info.valid_data) {
      note_batch(&received, batch->number, batch->samples._length);
      for (uint32_t i = 0; i < batch->cycles._length; ++i)
        note_cycle(&received, batch->cycles._buffer[i].cycle, batch->cycles._buffer[i].wall_time_ns);
    }
    dds_return_loan(reader, samples, 1);
  }
}

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: cyclone_reader DOMAIN\n");
    return 2;
  }
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &end, NULL);
  const dds_domainid_t domain = (dds_domainid_t)strtoul(argv[1], NULL, 10);
  checked(dds_create_domain(domain, kLoopbackOnly), "domain");
  const dds_entity_t participant = checked(dds_create_participant(domain, NULL, NULL), "participant");
  const dds_entity_t topic = checked(
      dds_create_topic(participant, &driveline_telemetry_AxisBatch_desc, "driveline/v1/axis_batch", NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 256);
  dds_listener_t* listener = dds_create_listener(NULL);
  dds_lset_data_available(listener, on_data);
  const dds_entity_t reader = checked(dds_create_reader(participant, topic, qos, listener), "reader");
  dds_delete_qos(qos);
  dds_delete_listener(listener);
  int signal_number = 0;
  sigwait(&end, &signal_number);
  dds_delete(reader);
  print_received(&received);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return 0;
}
