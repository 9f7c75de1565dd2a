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

/// Some masters include the terminating 0 in the name.
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
  transfer_.reset();
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
  if (transfer_) transfer_->state = request.state;
  switch (header->op_code) {
    case FoeOpCode::kReadRequest:
    case FoeOpCode::kWriteRequest: {
      stop();
      const auto name = name_of(data);
      const FileRequest file{name, header->value, request.state};
      return header->op_code == FoeOpCode::kReadRequest ? start_reading(file, out) : start_writing(file, out);
    }
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

std::size_t FoeServer::start_reading(const FileRequest& file, std::span<std::byte> out) {
  auto content = files_->read_file(file);
  if (!content) return refuse(content.error(), out);
  transfer_ = std::make_unique<Transfer>(
      Transfer{Phase::kReading, std::string(file.name), file.password, file.state, std::move(*content)});
  return send_packet(out);
}

std::size_t FoeServer::send_packet(std::span<std::byte> out) {
  auto& transfer = *transfer_;
  const auto room = out.size() - FoeHeader::kSize;
  const auto rest = std::span(transfer.content).subspan(transfer.sent);
  const auto length = std::min(rest.size(), room);
  std::copy_n(rest.begin(), length, out.begin() + FoeHeader::kSize);
  transfer.sent += length;
  transfer.last = length < room;
  return with_header(FoeOpCode::kData, ++transfer.packet, length, out);
}

std::size_t FoeServer::acknowledged(std::uint32_t number, std::span<std::byte> out) {
  if (!in(Phase::kReading)) return refuse({FoeError::kIllegal, "no file is being read"}, out);
  if (number != transfer_->packet) return refuse({FoeError::kPacketNumber, {}}, out);
  if (!transfer_->last) return send_packet(out);
  stop();
  return 0;
}

std::size_t FoeServer::start_writing(const FileRequest& file, std::span<std::byte> out) {
  const auto limit = files_->open_file(file);
  if (!limit) return refuse(limit.error(), out);
  transfer_ = std::make_unique<Transfer>(
      Transfer{Phase::kWriting, std::string(file.name), file.password, file.state, {}, 0, *limit});
  return with_header(FoeOpCode::kAck, 0, 0, out);
}

std::size_t FoeServer::take_data(std::uint32_t number, std::span<const std::byte> data, std::size_t room,
                                 std::span<std::byte> out) {
  if (in(Phase::kKeeping) && number == transfer_->packet) return keep(out);
  if (!in(Phase::kWriting)) return refuse({FoeError::kIllegal, "no file is being written"}, out);
  auto& transfer = *transfer_;
  if (number != transfer.packet + 1) return refuse({FoeError::kPacketNumber, {}}, out);
  if (data.size() > transfer.limit - transfer.content.size()) {
    return refuse({FoeError::kDiskFull, "at most " + std::to_string(transfer.limit) + " bytes"}, out);
  }
  transfer.content.insert(transfer.content.end(), data.begin(), data.end());
  transfer.packet = number;
  if (data.size() >= room) return with_header(FoeOpCode::kAck, number, 0, out);
  if (const auto written = files_->write_file(transfer.file(), transfer.content); !written)
    return refuse(written.error(), out);
  transfer.phase = Phase::kKeeping;
  return keep(out);
}

std::size_t FoeServer::keep(std::span<std::byte> out) {
  if (const auto busy = files_->busy()) return with_header(FoeOpCode::kBusy, busy->value(), 0, out);
  const auto packet = transfer_->packet;
  stop();
  return with_header(FoeOpCode::kAck, packet, 0, out);
}

}  // namespace driveline::slaves
