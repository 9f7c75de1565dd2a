#include "driveline/slaves/mailbox/foe_server.hpp"

#include <algorithm>

namespace driveline::slaves {
namespace {

using wire::FoeError;
using wire::FoeHeader;
using wire::FoeOpCode;
using wire::MailboxErrorCode;

std::size_t with_header(FoeOpCode op_code, std::uint32_t value, std::size_t length, std::span<std::byte> out) {
  FoeHeader{op_code, value}.encode(out.first<FoeHeader::kSize>());
  return FoeHeader::kSize + length;
}

/// Some masters write the 0 behind the name, too.
std::string name_of(std::span<const std::byte> data) {
  std::string name;
  for (const auto byte : data) {
    if (byte == std::byte{0}) break;
    name += static_cast<char>(byte);
  }
  return name;
}

}  // namespace

void FoeServer::stop() noexcept {
  phase_ = Phase::kIdle;
  content_.clear();
}

std::size_t FoeServer::refuse(const FileRefusal& refusal, std::span<std::byte> out) {
  stop();
  const auto text = std::as_bytes(std::span(refusal.text));
  const auto length = std::min(text.size(), out.size() - FoeHeader::kSize);
  std::copy_n(text.begin(), length, out.begin() + FoeHeader::kSize);
  return with_header(FoeOpCode::kError, static_cast<std::uint32_t>(refusal.code), length, out);
}

tl::expected<std::size_t, MailboxErrorCode> FoeServer::request(const MailboxRequest& request,
                                                               std::span<std::byte> out) {
  const auto header = FoeHeader::decode(request.data);
  if (!header) return tl::unexpected(MailboxErrorCode::kSizeTooShort);
  if (out.size() <= FoeHeader::kSize) return tl::unexpected(MailboxErrorCode::kNoMoreMemory);
  const auto data = request.data.subspan(FoeHeader::kSize);
  state_ = request.state;
  switch (header->op_code) {
    case FoeOpCode::kReadRequest:
    case FoeOpCode::kWriteRequest:
      name_ = name_of(data);
      password_ = header->value;
      stop();
      return header->op_code == FoeOpCode::kReadRequest ? start_reading(out) : start_writing(out);
    case FoeOpCode::kAck:
      return acknowledged(header->value, out);
    case FoeOpCode::kData:
      return take_data(header->value, data, request.room - std::min(request.room, FoeHeader::kSize), out);
    case FoeOpCode::kError:
      stop();
      return 0;
    case FoeOpCode::kBusy:
      return 0;
    default:
      return refuse({FoeError::kIllegal, "no such operation"}, out);
  }
}

std::size_t FoeServer::start_reading(std::span<std::byte> out) {
  auto content = files_->read_file(file());
  if (!content) return refuse(content.error(), out);
  content_ = std::move(*content);
  phase_ = Phase::kReading;
  packet_ = 0;
  sent_ = 0;
  return send_packet(out);
}

std::size_t FoeServer::send_packet(std::span<std::byte> out) {
  const auto room = out.size() - FoeHeader::kSize;
  const auto length = std::min(content_.size() - sent_, room);
  std::copy_n(content_.begin() + static_cast<std::ptrdiff_t>(sent_), length, out.begin() + FoeHeader::kSize);
  sent_ += length;
  last_ = length < room;
  return with_header(FoeOpCode::kData, ++packet_, length, out);
}

std::size_t FoeServer::acknowledged(std::uint32_t number, std::span<std::byte> out) {
  if (phase_ != Phase::kReading) return refuse({FoeError::kIllegal, "no file is being read"}, out);
  if (number != packet_) return refuse({FoeError::kPacketNumber, {}}, out);
  if (!last_) return send_packet(out);
  stop();
  return 0;
}

std::size_t FoeServer::start_writing(std::span<std::byte> out) {
  const auto limit = files_->open_file(file());
  if (!limit) return refuse(limit.error(), out);
  limit_ = *limit;
  phase_ = Phase::kWriting;
  packet_ = 0;
  return with_header(FoeOpCode::kAck, 0, 0, out);
}

std::size_t FoeServer::take_data(std::uint32_t number, std::span<const std::byte> data, std::size_t room,
                                 std::span<std::byte> out) {
  if (phase_ == Phase::kKeeping && number == packet_) return keep(out);
  if (phase_ != Phase::kWriting) return refuse({FoeError::kIllegal, "no file is being written"}, out);
  if (number != packet_ + 1) return refuse({FoeError::kPacketNumber, {}}, out);
  if (data.size() > limit_ - content_.size()) {
    return refuse({FoeError::kDiskFull, "at most " + std::to_string(limit_) + " bytes"}, out);
  }
  content_.insert(content_.end(), data.begin(), data.end());
  packet_ = number;
  if (data.size() >= room) return with_header(FoeOpCode::kAck, packet_, 0, out);
  if (const auto written = files_->write_file(file(), content_); !written) return refuse(written.error(), out);
  phase_ = Phase::kKeeping;
  return keep(out);
}

std::size_t FoeServer::keep(std::span<std::byte> out) {
  if (const auto busy = files_->busy()) return with_header(FoeOpCode::kBusy, busy->value(), 0, out);
  stop();
  return with_header(FoeOpCode::kAck, packet_, 0, out);
}

}  // namespace driveline::slaves
