#include "driveline/ecat_master/foe/file_transfer.hpp"

#include <algorithm>
#include <utility>

namespace driveline::ecat_master {
namespace {

using wire::FoeError;
using wire::FoeHeader;
using wire::FoeOpCode;

}  // namespace

FileTransfer::FileTransfer(FileName file, const FileSettings& settings)
    : MailboxDialogue(wire::MailboxType::kFoe, 0), file_(std::move(file)), write_(false), settings_(settings) {}

FileTransfer::FileTransfer(FileName file, std::vector<std::byte> content, const FileSettings& settings)
    : MailboxDialogue(wire::MailboxType::kFoe, 0),
      file_(std::move(file)),
      write_(true),
      settings_(settings),
      content_(std::move(content)),
      size_(content_.size()) {}

void FileTransfer::load(FoeOpCode op_code, std::uint32_t value, std::span<const std::byte> data) {
  outgoing_.resize(FoeHeader::kSize + data.size());
  FoeHeader{op_code, value}.encode(std::span(outgoing_).first<FoeHeader::kSize>());
  std::copy(data.begin(), data.end(), outgoing_.begin() + FoeHeader::kSize);
}

void FileTransfer::begin(std::uint16_t position, MailboxRoom room) {
  position_ = position;
  out_room_ = room.out - std::min(room.out, FoeHeader::kSize);
  in_room_ = room.in - std::min(room.in, FoeHeader::kSize);
  packet_ = write_ ? 0 : 1;
  load(write_ ? FoeOpCode::kWriteRequest : FoeOpCode::kReadRequest, file_.password,
       std::as_bytes(std::span(file_.name)));
  // Mailboxes without room for data are refused as too small; else the file would never end.
  if (out_room_ == 0 || in_room_ == 0) outgoing_.resize(room.out + 1);
}

MailboxDialogue::Reaction FileTransfer::stray() {
  stray_ = true;
  return Reaction::kForeign;
}

MailboxDialogue::Reaction FileTransfer::receive(std::span<const std::byte> service) {
  const auto header = FoeHeader::decode(service);
  if (!header) return stray();
  const auto rest = service.subspan(FoeHeader::kSize);
  switch (header->op_code) {
    case FoeOpCode::kError:
      return receive_error(header->value, rest);
    case FoeOpCode::kBusy:
      return receive_busy();
    case FoeOpCode::kAck:
      return write_ ? receive_ack(header->value) : stray();
    case FoeOpCode::kData:
      return write_ ? stray() : receive_data(header->value, rest);
    default:
      return stray();
  }
}

/// A late or repeated answer belongs to the request or to the previous packet.
MailboxDialogue::Reaction FileTransfer::wrong_packet(std::uint32_t number) {
  const std::uint32_t first = write_ ? 0 : 1;
  if (packet_ == first || number + 1 == packet_) return stray();
  return give_up({facts::FilePacket{packet_, number}, position_}, FoeError::kPacketNumber);
}

MailboxDialogue::Reaction FileTransfer::receive_ack(std::uint32_t number) {
  if (number != packet_) return wrong_packet(number);
  paused_ = pause_ = {};
  transferred_.fetch_add(packet_bytes_, std::memory_order_relaxed);
  if (last_packet_) {
    result_ = std::vector<std::byte>{};
    return Reaction::kDone;
  }
  load_packet();
  return Reaction::kSend;
}

void FileTransfer::load_packet() {
  const auto rest = std::span(content_).subspan(transferred());
  packet_bytes_ = std::min(rest.size(), out_room_);
  last_packet_ = packet_bytes_ < out_room_;
  load(FoeOpCode::kData, ++packet_, rest.first(packet_bytes_));
}

MailboxDialogue::Reaction FileTransfer::receive_data(std::uint32_t number, std::span<const std::byte> data) {
  if (number != packet_) return wrong_packet(number);
  paused_ = pause_ = {};
  if (data.size() > settings_.largest - content_.size()) {
    return give_up({facts::FileSize{settings_.largest}, position_}, FoeError::kDiskFull);
  }
  content_.insert(content_.end(), data.begin(), data.end());
  transferred_.store(content_.size(), std::memory_order_relaxed);
  load(FoeOpCode::kAck, packet_++);
  if (data.size() < in_room_) {
    last_word_ = true;
    result_ = std::move(content_);
  }
  return Reaction::kSend;
}

MailboxDialogue::Reaction FileTransfer::receive_busy() {
  pause_ =
      pause_ == std::chrono::nanoseconds{0} ? settings_.first_pause : std::min(2 * pause_, settings_.longest_pause);
  paused_ += pause_;
  if (paused_ > settings_.busy_limit) {
    return give_up({facts::FileBusy{paused_ - pause_}, position_}, FoeError::kNotDefined);
  }
  return Reaction::kPause;
}

MailboxDialogue::Reaction FileTransfer::receive_error(std::uint32_t code, std::span<const std::byte> text) {
  for (const auto byte : text) {
    if (byte == std::byte{0}) break;
    slave_text_ += static_cast<char>(byte);
  }
  result_ = tl::unexpected(Error{facts::FileRefused{static_cast<FoeError>(code)}, position_});
  return Reaction::kDone;
}

/// Ends the transfer with an error; a lost error message only leaves the slave waiting.
MailboxDialogue::Reaction FileTransfer::give_up(const Error& error, FoeError code) {
  result_ = tl::unexpected(error);
  load(FoeOpCode::kError, static_cast<std::uint32_t>(code));
  last_word_ = true;
  return Reaction::kSend;
}

bool FileTransfer::takes_leave() {
  load(FoeOpCode::kError, static_cast<std::uint32_t>(FoeError::kNotDefined));
  last_word_ = true;
  return true;
}

void FileTransfer::fail(const Error& failure) {
  // Keep the first failure: whether the error reaches the slave makes no difference.
  if (last_word_) return;
  auto error = failure;
  if (stray_ && error.is<facts::MailboxTimeout>()) error.facts = facts::MailboxMalformed{};
  result_ = tl::unexpected(error);
}

}  // namespace driveline::ecat_master
