#include "command_relay.hpp"

#include <cstring>
#include <utility>
#include <variant>

namespace driveline::bridge {
namespace {

/// Of one call, either way.
constexpr int kMostAtOnce = 256;

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
  auto dds = DdsCommands::create(publisher);
  if (!dds) return tl::unexpected(snapshot::FeedError{"commands", describe(dds.error())});
  return std::unique_ptr<CommandRelay>(new CommandRelay(*std::move(dds), *std::move(commands), *std::move(answers)));
}

CommandRelay::CommandRelay(std::unique_ptr<DdsCommands> dds, rt::SharedMapping commands, rt::SharedMapping answers)
    : dds_(std::move(dds)),
      commands_(std::move(commands)),
      answers_(std::move(answers)),
      writer_(commands_),
      reader_(answers_),
      record_(reader_.record_words()) {}

void CommandRelay::serve() {
  snapshot::CommandRecord command;
  for (int i = 0; i < kMostAtOnce && dds_->take(command); ++i) {
    if (!writer_.try_push(command)) dds_->refuse(command);
  }
  snapshot::CommandAnswer answer;
  for (int i = 0; i < kMostAtOnce && reader_.take(record_); ++i) {
    std::memcpy(static_cast<void*>(&answer), record_.data(), sizeof(answer));
    dds_->answer(answer);
  }
}

}  // namespace driveline::bridge
