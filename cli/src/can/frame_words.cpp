#include "can/frame_words.hpp"

#include <fmt/format.h>

#include <optional>

#include "driveline/canopen_wire/sdo_block.hpp"
#include "driveline/canopen_wire/sync.hpp"
#include "driveline/motion/cia402/error_code.hpp"

namespace driveline::cli {
namespace {

using canopen::Frame;
using canopen::FrameKind;
using canopen::SdoMessage;
using canopen::SdoSegment;
namespace predefined = canopen::predefined;
namespace block = canopen::sdo_block;

struct CodeName {
  std::uint16_t code;
  std::string_view name;
};

/// Codes of the communication (CiA 301 Table 26), which CiA 402 has as a group only.
constexpr std::array kCommunicationCodes = {
    CodeName{0x8110, "CAN overrun, frames were lost"},
    CodeName{0x8120, "CAN in error passive mode"},
    CodeName{0x8130, "life guarding or heartbeat"},
    CodeName{0x8140, "recovered from bus off"},
    CodeName{0x8150, "CAN identifier collision"},
    CodeName{0x8210, "PDO not processed because of its length"},
    CodeName{0x8220, "PDO longer than mapped"},
    CodeName{0x8230, "destination object of a multiplexed PDO not available"},
    CodeName{0x8240, "unexpected length of SYNC"},
    CodeName{0x8250, "RPDO time-out"},
};

/// The node of an identifier that begins at `base`; 0: it belongs to no node.
std::uint8_t node_at(std::uint32_t value, std::uint32_t base) {
  return value > base && value <= base + canopen::kMaxNodeId ? static_cast<std::uint8_t>(value - base)
                                                             : std::uint8_t{0};
}

std::string object_words(const SdoMessage& message) {
  return fmt::format("0x{:04X}:{:02X}", message.index, message.subindex);
}

/// The value of an expedited transfer.
std::string value_words(const SdoMessage& message) {
  const auto size = message.expedited_size();
  const auto mask = size == 4 ? 0xFFFF'FFFFU : (1U << 8U * size) - 1U;
  return fmt::format("0x{:0{}X}", message.number() & mask, 2 * size);
}

std::string abort_words(const SdoMessage& message) {
  return fmt::format("abort of {}: 0x{:08X} ({})", object_words(message), message.number(),
                     to_text(static_cast<canopen::SdoAbort>(message.number())));
}

std::string segment_words(std::span<const std::byte> payload) {
  const auto header = SdoSegment::decode(payload[0]);
  return fmt::format("segment, toggle {}{}: {}", header.toggle ? 1 : 0, header.last ? ", last" : "",
                     bytes_words(payload.subspan(1, SdoSegment::kData - header.unused)));
}

std::string confirm_words(std::span<const std::byte> payload) {
  return fmt::format("sub-block received up to segment {}, next with {} segments",
                     std::to_integer<unsigned>(payload[1]), std::to_integer<unsigned>(payload[2]));
}

std::string nmt_words(const Frame& frame) {
  const auto request = canopen::NmtRequest::decode(frame.payload());
  if (!request) return "not two bytes";
  const auto whom = request->node == 0 ? std::string("all nodes") : fmt::format("node {}", request->node);
  switch (request->command) {
    case canopen::NmtCommand::kStart:
      return "start " + whom;
    case canopen::NmtCommand::kStop:
      return "stop " + whom;
    case canopen::NmtCommand::kEnterPreOperational:
      return "enter pre-operational " + whom;
    case canopen::NmtCommand::kResetNode:
      return "reset " + whom;
    case canopen::NmtCommand::kResetCommunication:
      return "reset communication of " + whom;
  }
  return fmt::format("unknown command 0x{:02X} to {}", static_cast<unsigned>(request->command), whom);
}

std::string sync_words(const Frame& frame) {
  const auto sync = canopen::Sync::decode(frame.payload());
  if (!sync) return "more than one byte";
  return sync->counter == 0 ? std::string() : fmt::format("counter {}", sync->counter);
}

std::string time_words(const Frame& frame) {
  const auto time = canopen::TimeOfDay::decode(frame.payload());
  if (!time) return "not six bytes";
  return fmt::format("day {} after 1 January 1984, {:.3f} s", time->days, time->milliseconds / 1000.0);
}

FrameWords error_control_words(const Frame& frame, std::uint8_t node) {
  if (frame.kind == FrameKind::kRemote) return {fmt::format("guarding request node {}", node), "", node};
  const auto message = canopen::ErrorControl::decode(frame.payload());
  if (!message) return {fmt::format("error control node {}", node), "not one byte", node};
  if (message->state == canopen::NmtState::kInitialising && !message->toggle) {
    return {fmt::format("boot-up node {}", node), "", node};
  }
  auto meaning = nmt_state_words(message->state);
  if (message->toggle) meaning += ", toggle 1";
  return {fmt::format("heartbeat node {}", node), meaning, node};
}

/// PDO n of a node, by the predefined identifiers.
std::optional<FrameWords> pdo_words(std::uint32_t identifier, bool remote) {
  for (std::size_t i = 0; i < predefined::kTxPdo.size(); ++i) {
    for (const bool transmit : {true, false}) {
      const auto node = node_at(identifier, transmit ? predefined::kTxPdo.at(i) : predefined::kRxPdo.at(i));
      if (node == 0) continue;
      return FrameWords{fmt::format("{}PDO{} node {}", transmit ? 'T' : 'R', i + 1, node),
                        remote ? "request of its values" : "", node};
    }
  }
  return std::nullopt;
}

}  // namespace

std::string nmt_state_words(canopen::NmtState state) {
  switch (state) {
    case canopen::NmtState::kInitialising:
      return "initialising";
    case canopen::NmtState::kStopped:
      return "stopped";
    case canopen::NmtState::kOperational:
      return "operational";
    case canopen::NmtState::kPreOperational:
      return "pre-operational";
  }
  return fmt::format("unknown state {}", static_cast<unsigned>(state));
}

std::string emergency_code_words(std::uint16_t code) {
  if (code == canopen::emergency_code::kNoError) return "no error";
  for (const auto& row : kCommunicationCodes) {
    if (row.code == code) return fmt::format("0x{:04X}, {}", code, row.name);
  }
  return motion::cia402::error_text(code);
}

std::string emergency_words(const canopen::Emergency& emergency) {
  return fmt::format("{}, error register 0x{:02X}, {}", emergency_code_words(emergency.code), emergency.error_register,
                     bytes_words(emergency.manufacturer));
}

std::string bytes_words(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) {
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", std::to_integer<unsigned>(byte));
  }
  return text;
}

FrameWords FrameReader::read(const Frame& frame) {
  if (frame.kind == FrameKind::kError) return {"error frame", "", 0};
  if (frame.identifier.extended) return {};
  const auto value = frame.identifier.value;
  const bool remote = frame.kind == FrameKind::kRemote;
  if (value == predefined::kNmt) return {"NMT", remote ? "" : nmt_words(frame), 0};
  if (value == predefined::kSync) return {"SYNC", remote ? "" : sync_words(frame), 0};
  if (value == predefined::kTime) return {"TIME", remote ? "" : time_words(frame), 0};
  if (const auto node = node_at(value, predefined::kEmergency); node != 0) {
    const auto emergency = canopen::Emergency::decode(frame.payload());
    return {fmt::format("EMCY node {}", node), emergency ? emergency_words(*emergency) : "not eight bytes", node};
  }
  if (auto pdo = pdo_words(value, remote)) return *std::move(pdo);
  if (const auto node = node_at(value, predefined::kSdoServerToClient); node != 0) return read_sdo(frame, node, false);
  if (const auto node = node_at(value, predefined::kSdoClientToServer); node != 0) return read_sdo(frame, node, true);
  if (const auto node = node_at(value, predefined::kErrorControl); node != 0) return error_control_words(frame, node);
  return {};
}

FrameWords FrameReader::read_sdo(const Frame& frame, std::uint8_t node, bool request) {
  FrameWords words{fmt::format("SDO {} node {}", request ? "request" : "answer", node), "not eight bytes", node};
  const auto payload = frame.payload();
  if (payload.size() != SdoMessage::kSize) return words;
  auto& transfer = transfers_.at(node);
  const auto sender = request ? Block::kDownload : Block::kUpload;
  const auto segment = block::Segment::decode(payload[0]);
  if (transfer.segments == sender && segment.sequence != 0) {
    transfer.last_sequence = segment.sequence;
    transfer.complete = segment.last;
    if (segment.last) transfer.segments = Block::kNone;
    words.meaning = fmt::format("block segment {}{}: {}", segment.sequence, segment.last ? ", last" : "",
                                bytes_words(payload.subspan(1)));
    return words;
  }
  words.meaning = request ? request_meaning(payload, transfer) : answer_meaning(payload, transfer);
  return words;
}

std::string FrameReader::request_meaning(std::span<const std::byte> payload, Transfer& transfer) {
  const auto message = *SdoMessage::decode(payload);
  const unsigned subcommand = message.command & 3U;
  // Behind the last segment that was received there is none; others come again.
  const bool all_received = transfer.complete && std::to_integer<std::uint8_t>(payload[1]) == transfer.last_sequence;
  switch (static_cast<canopen::SdoRequest>(message.specifier())) {
    case canopen::SdoRequest::kDownloadSegment:
      return segment_words(payload);
    case canopen::SdoRequest::kInitiateDownload:
      transfer = {};
      if (message.expedited()) return fmt::format("download {} = {}", object_words(message), value_words(message));
      return fmt::format("download {}, {} bytes", object_words(message), message.number());
    case canopen::SdoRequest::kInitiateUpload:
      transfer = {};
      return "upload " + object_words(message);
    case canopen::SdoRequest::kUploadSegment:
      return fmt::format("next segment, toggle {}", SdoSegment::decode(payload[0]).toggle ? 1 : 0);
    case canopen::SdoRequest::kAbort:
      transfer = {};
      return abort_words(message);
    case canopen::SdoRequest::kBlockUpload:
      if (subcommand == block::kUploadEnd) return "block upload received";
      if (subcommand == block::kUploadInitiate) {
        transfer = {};
        return fmt::format("block upload {}, {} segments", object_words(message),
                           std::to_integer<int>(message.data[0]));
      }
      transfer.segments = subcommand == block::kUploadConfirm && all_received ? Block::kNone : Block::kUpload;
      return subcommand == block::kUploadStart ? std::string("start of the block upload") : confirm_words(payload);
    case canopen::SdoRequest::kBlockDownload:
      if ((message.command & 1U) == block::kDownloadEnd) return "end of the block download";
      transfer = {};
      return fmt::format("block download {}, {} bytes", object_words(message), message.number());
  }
  return "unknown command";
}

std::string FrameReader::answer_meaning(std::span<const std::byte> payload, Transfer& transfer) {
  const auto message = *SdoMessage::decode(payload);
  const unsigned subcommand = message.command & 3U;
  const bool all_received = transfer.complete && std::to_integer<std::uint8_t>(payload[1]) == transfer.last_sequence;
  switch (static_cast<canopen::SdoResponse>(message.specifier())) {
    case canopen::SdoResponse::kUploadSegment:
      return segment_words(payload);
    case canopen::SdoResponse::kDownloadSegment:
      return fmt::format("segment received, toggle {}", SdoSegment::decode(payload[0]).toggle ? 1 : 0);
    case canopen::SdoResponse::kInitiateUpload:
      if (message.expedited()) return fmt::format("{} = {}", object_words(message), value_words(message));
      if (!message.size_indicated()) return object_words(message) + " in segments";
      return fmt::format("{} has {} bytes", object_words(message), message.number());
    case canopen::SdoResponse::kInitiateDownload:
      return object_words(message) + " written, or segments expected";
    case canopen::SdoResponse::kAbort:
      transfer = {};
      return abort_words(message);
    case canopen::SdoResponse::kBlockDownload:
      if (subcommand == block::kDownloadEnd) return "block download received";
      if (subcommand == block::kDownloadInitiate) {
        transfer = {Block::kDownload, 0, false};
        return fmt::format("block download {}, {} segments", object_words(message),
                           std::to_integer<int>(message.data[0]));
      }
      transfer.segments = all_received ? Block::kNone : Block::kDownload;
      return confirm_words(payload);
    case canopen::SdoResponse::kBlockUpload:
      if (subcommand == block::kUploadEnd) return "end of the block upload";
      return fmt::format("block upload {}, {} bytes", object_words(message), message.number());
  }
  return "unknown command";
}

}  // namespace driveline::cli
