#include "driveline/canopen_client/client_error.hpp"

#include <fmt/format.h>

namespace driveline::canopen {
namespace {

double milliseconds_of(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

std::string object_words(const ClientError& error) {
  return fmt::format("object 0x{:04X}:{:02X}", error.object.index, error.object.subindex);
}

std::string code_words(const ClientError& error) {
  return fmt::format("0x{:08X} ({})", static_cast<std::uint32_t>(error.code), sdo::to_text(error.code));
}

std::string no_answer(const ClientError& error) {
  auto text = fmt::format("node {} did not answer within {:.0f} ms", error.node, milliseconds_of(error.waited));
  if (error.object.index != 0) text += fmt::format(", when asked for {}", object_words(error));
  if (error.ignored != 0)
    text += fmt::format("; {} of its answers belong to no request of this program", error.ignored);
  return text;
}

std::string bad_answer(const ClientError& error) {
  auto text =
      fmt::format("node {}: {}: the transfer was ended with {}", error.node, object_words(error), code_words(error));
  if (error.expected != 0 || error.received != 0) {
    text += fmt::format("; the node has {} bytes, {} were expected", error.received, error.expected);
  }
  return text;
}

}  // namespace

std::string describe(const ClientError& error) {
  switch (error.kind) {
    case ClientErrorKind::kDown:
      return "the CAN bus cannot be reached any more: the adapter or its connection has ended";
    case ClientErrorKind::kBusy:
      return fmt::format("the CAN adapter took no frame for {:.0f} ms: nobody acknowledges, or the bus is full",
                         milliseconds_of(error.waited));
    case ClientErrorKind::kNotCarried:
      return error.node == 0 ? "the CAN adapter cannot carry this frame"
                             : fmt::format("node {}: the CAN adapter cannot carry this frame", error.node);
    case ClientErrorKind::kNoAnswer:
      return no_answer(error);
    case ClientErrorKind::kAborted:
      return fmt::format("node {}: {} aborted with {}", error.node, object_words(error), code_words(error));
    case ClientErrorKind::kBadAnswer:
      return bad_answer(error);
    case ClientErrorKind::kStopped:
      return "stopped by a signal";
  }
  return "an unknown error";
}

}  // namespace driveline::canopen
