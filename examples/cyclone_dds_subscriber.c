/* Prints the positions of the axes of a line, received over DDS: cyclone_dds_subscriber [DOMAIN [SAMPLES]]. Uses
 * Cyclone DDS; `idlc driveline.idl` generates the types. Links nothing of driveline. */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "driveline.h"

/* By default a line publishes on loopback. On other interfaces the defaults of Cyclone DDS are sufficient. */
static const char kLoopback[] =
    "<Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>15</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain>";

int main(int argc, char** argv) {
  const dds_domainid_t domain = argc > 1 ? (dds_domainid_t)strtoul(argv[1], NULL, 10) : 0;
  unsigned long samples = argc > 2 ? strtoul(argv[2], NULL, 10) : 1000;
  if (getenv("CYCLONEDDS_URI") == NULL) dds_create_domain(domain, kLoopback);
  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  const dds_entity_t topic =
      dds_create_topic(participant, &driveline_telemetry_AxisTelemetry_desc, "driveline/axis_telemetry", NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0); /* like the writer */
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);          /* samples of each axis */
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (reader < 0) {
    fprintf(stderr, "no reader: %s\n", dds_strretcode(-reader));
    return EXIT_FAILURE;
  }
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_waitset_attach(waitset, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
  while (samples > 0 && dds_waitset_wait(waitset, NULL, 0, DDS_SECS(10)) > 0) {
    void* next = NULL; /* lent by Cyclone DDS */
    dds_sample_info_t info;
    while (samples > 0 && dds_take(reader, &next, &info, 1, 1) > 0) {
      const driveline_telemetry_AxisTelemetry* sample = next;
      if (info.valid_data) {
        printf("cycle %llu: %s is at %.6f %s\n", (unsigned long long)sample->cycle, sample->name, sample->actual_position,
               sample->kind == driveline_telemetry_AXIS_ROTARY ? "rad" : "m");
        --samples;
      }
      dds_return_loan(reader, &next, 1);
      next = NULL;
    }
  }
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return samples == 0 ? EXIT_SUCCESS : EXIT_FAILURE; /* nothing came for 10 s */
}
