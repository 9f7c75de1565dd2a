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
 *   stream x,y 0.5 1 20 1000         streams a swing of 0.5 rad amplitude at 1 Hz around where the axes are, in batches of 20
 *                                    setpoints of 1000 a second, 5 batches ahead of the line
 *   batch x 7 1000 3.5 0 0           one setpoint: number, time in ms, position, velocity, acceleration
 *   follow x                         the axes of the stream are to follow again
 *   end x                            ends the stream
 *
 * and prints a document for what it is told of its stream whenever its state, its text, or who follows has changed.
 *
 * Ends at the end of stdin, without a word to the line. Status 2: bad usage, or DDS refuses to start. It stays on the
 * loopback interface unless CYCLONEDDS_URI says otherwise.
 */
#include <dds/dds.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cyclone_tool.h"
#include "commands.h"

typedef driveline_commands_Command Command;
typedef driveline_commands_CommandAnswer Answer;
typedef driveline_commands_SetpointBatch Batch;
typedef driveline_commands_StreamStatus StreamStatus;

enum { kMaxAxes = 8, kKinds = 12, kLongestLine = 512 };

static const char* const kKindNames[kKinds] = {"acquire",      "renew", "release",       "enable",
                                               "disable",      "reset", "halt",          "quick-stop",
                                               "release-stop", "jog",   "move-absolute", "move-relative"};
static const char* const kResultNames[] = {"ACCEPTED", "DONE", "REFUSED", "ABORTED"};

static struct {
  char name[32];
  uint64_t lease;
} axes[kMaxAxes];

static const char* client;
static uint64_t number;
static dds_entity_t writer, reader, setpoint_writer, status_reader;

/* Of the axis; a place for it is made where there is none. */
static uint64_t* lease_of(const char* axis) {
  for (int i = 0; i < kMaxAxes; ++i) {
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

static const char* const kStateNames[] = {"WAITING", "STREAMING", "STARVED", "ENDING", "OVER", "REFUSED"};
enum { kLeadBatches = 5, kMaxInBatch = 64, kMaxStreamed = 4 };

/* What is streamed. */
static struct {
  char axes[64]; /* names with commas */
  double amplitude, hertz, rate;
  uint32_t batch;
  uint64_t number;      /* of the next setpoint */
  int64_t stream_ns;    /* of the line, as it was told last */
  double middle[kMaxStreamed];
  int on;
} stream;

static StreamStatus status;

/* The axes with these names, into a batch; how many. */
static uint32_t put_axes(Batch* batch, const char* names) {
  static driveline_commands_StreamedAxis places[kMaxStreamed];
  char copy[64];
  char* rest = NULL;
  uint32_t count = 0;
  snprintf(copy, sizeof(copy), "%s", names);
  for (char* name = strtok_r(copy, ",", &rest); name != NULL && count < kMaxStreamed; name = strtok_r(NULL, ",", &rest)) {
    snprintf(places[count].axis, sizeof(places[count].axis), "%s", name);
    places[count++].lease = *lease_of(name);
  }
  batch->axes._buffer = places;
  batch->axes._length = batch->axes._maximum = count;
  return count;
}

static void write_batch(Batch* batch) {
  snprintf(batch->client, sizeof(batch->client), "%s", client);
  const dds_return_t done = dds_write(setpoint_writer, batch);
  if (done < 0) fprintf(stderr, "cyclone_commander: %s\n", dds_strretcode(-done));
}

/* A batch without setpoints. */
static void say_to_stream(driveline_commands_SetpointKind kind, const char* names) {
  Batch batch;
  memset(&batch, 0, sizeof(batch));
  batch.kind = kind;
  put_axes(&batch, names);
  write_batch(&batch);
}

static void send_one(const char* names, const double* values, double acceleration) {
  driveline_commands_AxisTarget targets[kMaxStreamed];
  driveline_commands_Setpoint setpoint = {(int64_t)(values[1] * 1e6), {0, 0, NULL, false}};
  Batch batch;
  memset(&batch, 0, sizeof(batch));
  const uint32_t count = put_axes(&batch, names);
  for (uint32_t i = 0; i < count; ++i) {
    targets[i].position = values[2];
    targets[i].velocity = values[3];
    targets[i].acceleration = acceleration;
  }
  setpoint.targets._buffer = targets;
  setpoint.targets._length = setpoint.targets._maximum = count;
  batch.number = (uint64_t)values[0];
  batch.setpoints._buffer = &setpoint;
  batch.setpoints._length = batch.setpoints._maximum = 1;
  write_batch(&batch);
}

/* The next batch of the swing, as long as the line is not far enough behind. */
static void go_on_streaming(void) {
  static driveline_commands_AxisTarget targets[kMaxInBatch][kMaxStreamed];
  static driveline_commands_Setpoint setpoints[kMaxInBatch];
  const double pi = 3.14159265358979323846;
  while (stream.on) {
    const double ahead = (double)(stream.number - 1) / stream.rate - 1e-9 * (double)stream.stream_ns;
    if (ahead > kLeadBatches * stream.batch / stream.rate) return;
    Batch batch;
    memset(&batch, 0, sizeof(batch));
    const uint32_t count = put_axes(&batch, stream.axes);
    batch.number = stream.number;
    for (uint32_t i = 0; i < stream.batch; ++i) {
      const double seconds = (double)(stream.number++ - 1) / stream.rate;
      for (uint32_t axis = 0; axis < count; ++axis) {
        /* It begins and goes on without a leap of position or velocity. */
        targets[i][axis].position =
            stream.middle[axis] + stream.amplitude * (1 - cos(2 * pi * stream.hertz * seconds));
        targets[i][axis].velocity = stream.amplitude * 2 * pi * stream.hertz * sin(2 * pi * stream.hertz * seconds);
        targets[i][axis].acceleration = 0;
      }
      setpoints[i].time_ns = (int64_t)(seconds * 1e9);
      setpoints[i].targets._buffer = targets[i];
      setpoints[i].targets._length = setpoints[i].targets._maximum = count;
    }
    batch.setpoints._buffer = setpoints;
    batch.setpoints._length = batch.setpoints._maximum = stream.batch;
    write_batch(&batch);
  }
}

static void begin_stream(const char* names, const double* values) {
  memset(&stream, 0, sizeof(stream));
  snprintf(stream.axes, sizeof(stream.axes), "%s", names);
  stream.amplitude = values[0];
  stream.hertz = values[1];
  stream.batch = values[2] < 1 ? 1 : values[2] > kMaxInBatch ? kMaxInBatch : (uint32_t)values[2];
  stream.rate = values[3];
  for (int i = 0; i < kMaxStreamed; ++i) stream.middle[i] = values[4];
  stream.number = 1;
  stream.on = 1;
}

static void print_status(void) {
  printf("{\"stream\":\"%s\",\"taken\":%llu,\"refused\":%llu,\"starved\":%llu,\"axes\":{",
         (unsigned)status.state < 6 ? kStateNames[status.state] : "?", (unsigned long long)status.taken,
         (unsigned long long)status.refused, (unsigned long long)status.starved);
  for (uint32_t i = 0; i < status.axes._length; ++i) {
    if (i > 0) printf(",");
    print_string(status.axes._buffer[i].axis);
    printf(":{\"following\":%s,\"leased\":%s}", status.axes._buffer[i].following ? "true" : "false",
           status.axes._buffer[i].leased ? "true" : "false");
  }
  printf("},\"text\":");
  print_string(status.text);
  printf("}\n");
}

static void take_statuses(void) {
  static char text_before[256];
  static uint32_t state_before = 99, axes_before = 0;
  void* sample[1] = {&status};
  dds_sample_info_t info;
  while (dds_take(status_reader, sample, &info, 1, 1) > 0) {
    if (!info.valid_data || strcmp(status.client, client) != 0) continue;
    if (status.state == driveline_commands_STREAM_STREAMING) stream.stream_ns = status.stream_ns;
    uint32_t axes_now = 0;
    for (uint32_t i = 0; i < status.axes._length; ++i) {
      axes_now = 4 * axes_now + (status.axes._buffer[i].following ? 2 : 0) + (status.axes._buffer[i].leased ? 1 : 0);
    }
    if ((uint32_t)status.state == state_before && axes_now == axes_before && strcmp(status.text, text_before) == 0) continue;
    state_before = (uint32_t)status.state;
    axes_before = axes_now;
    snprintf(text_before, sizeof(text_before), "%s", status.text);
    print_status();
  }
  fflush(stdout);
}

/* Milliseconds between renewals. */
static int keep_ms;

static void obey(char* line) {
  static const char kSpace[] = " \n";
  char* word = strtok(line, kSpace);
  char* axis = strtok(NULL, kSpace);
  double values[6] = {0};
  if (word == NULL || axis == NULL) return;
  for (int i = 0; i < 6; ++i) {
    const char* text = strtok(NULL, kSpace);
    if (text != NULL) values[i] = strtod(text, NULL);
  }
  if (strcmp(word, "keep") == 0) {
    keep_ms = atoi(axis);
  } else if (strcmp(word, "lease") == 0) {
    *lease_of(axis) = (uint64_t)values[0];
  } else if (strcmp(word, "flood") == 0) {
    flood(axis, values[0]);
  } else if (strcmp(word, "stream") == 0) {
    begin_stream(axis, values);
  } else if (strcmp(word, "batch") == 0) {
    send_one(axis, values, values[4]);
  } else if (strcmp(word, "follow") == 0) {
    say_to_stream(driveline_commands_SETPOINTS_FOLLOW, axis);
  } else if (strcmp(word, "end") == 0) {
    stream.on = 0;
    say_to_stream(driveline_commands_SETPOINTS_END, axis);
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
  for (int i = 0; i < kMaxAxes && axes[i].name[0] != '\0'; ++i) {
    if (axes[i].lease != 0) send_command(driveline_commands_COMMAND_RENEW, axes[i].name, none);
  }
}

static void wait_for_line(void) {
  dds_publication_matched_status_t commands, setpoints;
  dds_subscription_matched_status_t answers, statuses;
  for (;;) {
    dds_get_publication_matched_status(writer, &commands);
    dds_get_subscription_matched_status(reader, &answers);
    dds_get_publication_matched_status(setpoint_writer, &setpoints);
    dds_get_subscription_matched_status(status_reader, &statuses);
    if (commands.current_count > 0 && answers.current_count > 0 && setpoints.current_count > 0 &&
        statuses.current_count > 0) {
      break;
    }
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
  const dds_entity_t setpoints =
      checked(dds_create_topic(participant, &driveline_commands_SetpointBatch_desc, "driveline/v1/setpoints", NULL, NULL),
              "topic");
  const dds_entity_t statuses = checked(
      dds_create_topic(participant, &driveline_commands_StreamStatus_desc, "driveline/v1/stream_status", NULL, NULL),
      "topic");
  writer = checked(dds_create_writer(participant, commands, qos, NULL), "writer");
  setpoint_writer = checked(dds_create_writer(participant, setpoints, qos, NULL), "writer");
  status_reader = checked(dds_create_reader(participant, statuses, qos, NULL), "reader");
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
    take_statuses();
    go_on_streaming();
  }
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return 0;
}
