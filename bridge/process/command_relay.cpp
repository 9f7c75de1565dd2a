#include "command_relay.hpp"

#include <cstring>
#include <utility>
#include <variant>

namespace driveline::bridge {
namespace {

/// Maximum number of records per call in either direction.
constexpr int kMaxAtOnce = 256;
/// Maximum number of setpoint batches per call.
constexpr int kMaxBatches = 16;

tl::expected<rt::SharedMapping, snapshot::FeedError> map_region(const char* name, int descriptor,
                                                                const rt::SharedLayout& layout) {
  auto mapped = rt::SharedMapping::open(descriptor, layout);
  if (const auto* error = std::get_if<rt::SharedRegionError>(&mapped)) {
    return tl::unexpected(snapshot::FeedError{name, rt::describe(*error)});
  }
  return std::move(*std::get_if<rt::SharedMapping>(&mapped));
}

}  // namespace

tl::expected<std::unique_ptr<CommandRelay>, snapshot::FeedError> CommandRelay::open(int descriptor,
                                                                                    DdsPublisher& publisher) {
  auto commands = map_region("commands", descriptor, snapshot::command_layout());
  if (!commands) return tl::unexpected(commands.error());
  auto answers = map_region("answers to commands", descriptor + 1, snapshot::command_answer_layout());
  if (!answers) return tl::unexpected(answers.error());
  auto setpoints = map_region("setpoints", descriptor + 2, snapshot::setpoint_layout());
  if (!setpoints) return tl::unexpected(setpoints.error());
  auto reports = map_region("reports about streams", descriptor + 3, snapshot::stream_report_layout());
  if (!reports) return tl::unexpected(reports.error());
  auto dds = DdsCommands::create(publisher);
  if (!dds) return tl::unexpected(snapshot::FeedError{"commands", describe(dds.error())});
  auto streams = DdsSetpoints::create(publisher);
  if (!streams) return tl::unexpected(snapshot::FeedError{"setpoints", describe(streams.error())});
  return std::unique_ptr<CommandRelay>(
      new CommandRelay(*std::move(dds), *std::move(streams),
                       {*std::move(commands), *std::move(answers), *std::move(setpoints), *std::move(reports)}));
}

CommandRelay::CommandRelay(std::unique_ptr<DdsCommands> dds, std::unique_ptr<DdsSetpoints> streams, Regions regions)
    : dds_(std::move(dds)),
      streams_(std::move(streams)),
      regions_(std::move(regions)),
      writer_(regions_.commands),
      reader_(regions_.answers),
      record_(reader_.record_words()),
      setpoint_writer_(regions_.setpoints),
      report_reader_(regions_.reports),
      report_record_(report_reader_.record_words()) {}

void CommandRelay::serve() {
  snapshot::CommandRecord command;
  for (int i = 0; i < kMaxAtOnce && dds_->take(command); ++i) {
    if (!writer_.try_push(command)) dds_->refuse(command);
  }
  serve_streams();
  snapshot::CommandAnswer answer;
  for (int i = 0; i < kMaxAtOnce && reader_.take(record_); ++i) {
    std::memcpy(static_cast<void*>(&answer), record_.data(), sizeof(answer));
    dds_->answer(answer);
  }
}

void CommandRelay::serve_streams() {
  for (int i = 0; i < kMaxBatches && streams_->take(batch_); ++i) {
    // Setpoints that do not fit are detected and counted by the line as missing numbers.
    for (const auto& setpoint : batch_) static_cast<void>(setpoint_writer_.try_push(setpoint));
  }
  snapshot::StreamReport report;
  for (int i = 0; i < kMaxAtOnce && report_reader_.take(report_record_); ++i) {
    std::memcpy(static_cast<void*>(&report), report_record_.data(), sizeof(report));
    streams_->report(report);
  }
}

}  // namespace driveline::bridge
