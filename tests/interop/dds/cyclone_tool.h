/* Common parts of the tools that see a drive line as another DDS implementation does: Cyclone DDS. */
#pragma once

#include <dds/dds.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* The entity; ends the tool with status 2 where DDS refuses it. */
static inline dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "%s: cannot create the %s: %s\n", program_invocation_short_name, what, dds_strretcode(-entity));
    _exit(2); /* exit() would unload the security plug-ins under threads that use them */
  }
  return entity;
}

/* A participant, on the loopback interface alone unless CYCLONEDDS_URI says otherwise. Loopback has no multicast flag on
 * most machines: a line is found by asking its discovery ports one by one. */
static inline dds_entity_t join_domain(dds_domainid_t domain) {
  static const char kLoopbackOnly[] =
      "<Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
      "<AllowMulticast>false</AllowMulticast></General>"
      "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>15</MaxAutoParticipantIndex>"
      "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain>";
  if (getenv("CYCLONEDDS_URI") == NULL) checked(dds_create_domain(domain, kLoopbackOnly), "domain");
  return checked(dds_create_participant(domain, NULL, NULL), "participant");
}

/* The number from 0 to `max` that `text` is; otherwise the tool tells its usage and ends with status 2. */
static inline unsigned long parse(const char* usage, const char* text, unsigned long max) {
  char* end = NULL;
  const unsigned long value = strtoul(text, &end, 10);
  if (text[0] < '0' || text[0] > '9' || *end != '\0' || value > max) {
    fprintf(stderr, "usage: %s %s\n", program_invocation_short_name, usage);
    exit(2);
  }
  return value;
}

/* As JSON. */
static inline void print_string(const char* text) {
  putchar('"');
  for (; *text != '\0'; ++text) {
    const unsigned char c = (unsigned char)*text;
    if (c == '"' || c == '\\') {
      printf("\\%c", c);
    } else if (c < 0x20) {
      printf("\\u%04x", c);
    } else {
      putchar(c);
    }
  }
  putchar('"');
}

/* With the quality of service of a ROS 2 node's reader. */
static inline dds_entity_t subscribe_as_ros2(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* name) {
  const dds_entity_t topic = checked(dds_create_topic(participant, type, name, NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  const dds_entity_t reader = checked(dds_create_reader(participant, topic, qos, NULL), "reader");
  dds_delete_qos(qos);
  return reader;
}

/* Takes messages until there are so many, or that point in time; how many, and the last of them. */
static inline unsigned long take_last(dds_entity_t reader, void* last, unsigned long wanted, dds_time_t deadline) {
  void* sample[1] = {last};
  dds_sample_info_t info;
  unsigned long messages = 0;
  while (messages < wanted && dds_time() < deadline) {
    dds_sleepfor(DDS_MSECS(2));
    while (messages < wanted && dds_take(reader, sample, &info, 1, 1) > 0) {
      if (info.valid_data) ++messages;
    }
  }
  return messages;
}

/* What the writer tells of its type in USER_DATA, as one more entry of a JSON document. */
static inline void print_user_data(dds_entity_t reader) {
  dds_instance_handle_t writer = 0;
  printf(",\"user_data\":\"");
  if (dds_get_matched_publications(reader, &writer, 1) > 0) {
    dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
    void* data = NULL;
    size_t length = 0;
    if (endpoint != NULL && dds_qget_userdata(endpoint->qos, &data, &length)) {
      printf("%.*s", (int)length, (const char*)data);
      dds_free(data);
    }
    if (endpoint != NULL) dds_builtintopic_free_endpoint(endpoint);
  }
  printf("\"");
}
