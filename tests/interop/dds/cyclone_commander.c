/* Commands the axes of a drive line with Cyclone DDS, and prints the answers.
 *
 *   cyclone_commander <domain> <client>
 *
 * Reads lines from stdin, and prints a JSON document in a line for each command that it has sent and for each answer to
 * its own commands:
 *
 *   acquire x                        names of commands: acquire renew release enable disable reset halt quick-stop
 *   jog x 0.5                        release-stop jog move-absolute move-relative; or a number
 *   move-absolute x 1 0.5 2          target, velocity, acceleration, deceleration, jerk
 *   lease x 17                       the lease of the axis is 17 from now on; answers set it otherwise
 *   keep 100                         renews the leases that it has every 100 ms; 0: does not
 *   flood x 3                        jogs as fast as it can for 3 s, without reading answers
 *
 * Ends at the end of stdin, without a word to the line. Status 2: bad usage, or DDS refuses to start. It stays on the
 * loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cyclone_tool.h"
#include "commands.h"

typedef driveline_commands_Command Command;
typedef driveline_commands_CommandAnswer Answer;

enum { kMostAxes = 8, kKinds = 12, kLongestLine = 512 };

static const char* const kKindNames[kKinds] = {"acquire",      "renew", "release",       "enable",
                                               "disable",      "reset", "halt",          "quick-stop",
                                               "release-stop", "jog",   "move-absolute", "move-relative"};
static const char* const kResultNames[] = {"ACCEPTED", "DONE", "REFUSED", "ABORTED"};

static struct {
  char name[32];
  uint64_t lease;
} axes[kMostAxes];

static const char* client;
static uint64_t number;
static dds_entity_t writer, reader;

/* Of the axis; a place for it is made where there is none. */
static uint64_t* lease_of(const char* axis) {
  for (int i = 0; i < kMostAxes; ++i) {
    if (axes[i].name[0] == '\0') snprintf(axes[i].name, sizeof(axes[i].name), "%s", axis);
    if (strcmp(axes[i].name, axis) == 0) return &axes[i].lease;
  }
  return &axes[0].lease;
}

static void send_command(uint32_t kind, char* axis, const double* values) {
  Command command;
  memset(&command, 0, sizeof(command));
  snprintf(command.client, sizeof(command.client), "%s", client);
  snprintf(command.axis, sizeof(command.axis), "%s", axis);
  command.number = ++number;
  command.kind = (driveline_commands_CommandKind)kind;
  command.lease = *lease_of(axis);
  command.target = values[0];
  command.velocity = values[1];
  command.acceleration = values[2];
  command.deceleration = values[3];
  command.jerk = values[4];
  const dds_return_t done = dds_write(writer, &command);
  if (done < 0) fprintf(stderr, "cyclone_commander: %s\n", dds_strretcode(-done));
}

static void take_answers(void) {
  static Answer answer;
  void* sample[1] = {&answer};
  dds_sample_info_t info;
  while (dds_take(reader, sample, &info, 1, 1) > 0) {
    if (!info.valid_data || strcmp(answer.client, client) != 0) continue;
    /* Renewals of an axis that is lost have an answer, too. */
    *lease_of(answer.axis) = answer.lease;
    printf("{\"number\":%llu,\"result\":\"%s\",\"lease\":%llu,\"axis\":", (unsigned long long)answer.number,
           (unsigned)answer.result < 4 ? kResultNames[answer.result] : "?", (unsigned long long)answer.lease);
    print_string(answer.axis);
    printf(",\"text\":");
    print_string(answer.text);
    printf("}\n");
  }
  fflush(stdout);
}

static void flood(char* axis, double seconds) {
  const double values[5] = {0.1};
  const dds_time_t end = dds_time() + (dds_time_t)(seconds * 1e9);
  const uint64_t before = number;
  while (dds_time() < end) send_command(driveline_commands_COMMAND_JOG, axis, values);
  printf("{\"flooded\":%llu}\n", (unsigned long long)(number - before));
  fflush(stdout);
}

/* Milliseconds between renewals. */
static int keep_ms;

static void obey(char* line) {
  static const char kSpace[] = " \n";
  char* word = strtok(line, kSpace);
  char* axis = strtok(NULL, kSpace);
  double values[5] = {0};
  if (word == NULL || axis == NULL) return;
  for (int i = 0; i < 5; ++i) {
    const char* text = strtok(NULL, kSpace);
    if (text != NULL) values[i] = strtod(text, NULL);
  }
  if (strcmp(word, "keep") == 0) {
    keep_ms = atoi(axis);
  } else if (strcmp(word, "lease") == 0) {
    *lease_of(axis) = (uint64_t)values[0];
  } else if (strcmp(word, "flood") == 0) {
    flood(axis, values[0]);
  } else {
    uint32_t kind = 0;
    while (kind < kKinds && strcmp(kKindNames[kind], word) != 0) ++kind;
    if (kind == kKinds) kind = (uint32_t)strtoul(word, NULL, 10);
    send_command(kind, axis, values);
    printf("{\"sent\":%llu}\n", (unsigned long long)number);
    fflush(stdout);
  }
}

/* What is there of stdin, line by line. 0: it has ended. */
static int read_lines(void) {
  static char text[kLongestLine + 1];
  static size_t length;
  const ssize_t got = read(STDIN_FILENO, text + length, kLongestLine - length);
  if (got <= 0) return 0;
  length += (size_t)got;
  text[length] = '\0';
  for (char* end = strchr(text, '\n'); end != NULL; end = strchr(text, '\n')) {
    *end = '\0';
    obey(text);
    length -= (size_t)(end + 1 - text);
    memmove(text, end + 1, length + 1);
  }
  return length < kLongestLine;
}

static void renew(void) {
  static dds_time_t next;
  const double none[5] = {0};
  if (keep_ms == 0 || dds_time() < next) return;
  next = dds_time() + DDS_MSECS(keep_ms);
  for (int i = 0; i < kMostAxes && axes[i].name[0] != '\0'; ++i) {
    if (axes[i].lease != 0) send_command(driveline_commands_COMMAND_RENEW, axes[i].name, none);
  }
}

static void wait_for_line(void) {
  dds_publication_matched_status_t commands;
  dds_subscription_matched_status_t answers;
  for (;;) {
    dds_get_publication_matched_status(writer, &commands);
    dds_get_subscription_matched_status(reader, &answers);
    if (commands.current_count > 0 && answers.current_count > 0) break;
    struct pollfd input = {STDIN_FILENO, 0, 0};
    if (poll(&input, 1, 10) > 0) exit(1); /* closed */
  }
  printf("{\"matched\":true}\n");
  fflush(stdout);
}

int main(int argc, char** argv) {
  if (argc != 3) {
    fprintf(stderr, "usage: cyclone_commander <domain> <client>\n");
    return 2;
  }
  const dds_domainid_t domain = (dds_domainid_t)strtoul(argv[1], NULL, 10);
  client = argv[2];
  const dds_entity_t participant = join_domain(domain);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  const dds_entity_t commands = checked(
      dds_create_topic(participant, &driveline_commands_Command_desc, "driveline/v1/command", NULL, NULL), "topic");
  const dds_entity_t answers =
      checked(dds_create_topic(participant, &driveline_commands_CommandAnswer_desc, "driveline/v1/command_answer", NULL,
                               NULL),
              "topic");
  writer = checked(dds_create_writer(participant, commands, qos, NULL), "writer");
  /* The line may have found the writer, and not yet the reader: it keeps its last answers. */
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  reader = checked(dds_create_reader(participant, answers, qos, NULL), "reader");
  dds_delete_qos(qos);
  wait_for_line();
  for (;;) {
    struct pollfd input = {STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 5) > 0 && !read_lines()) break;
    renew();
    take_answers();
  }
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return 0;
}
