#include "driveline/slaves/mailbox/soe_server.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

using wire::AlState;
using wire::MailboxErrorCode;
using wire::SoeError;
using wire::SoeHeader;
using wire::SoeOpCode;

/// Minimum size of a mailbox: header and error code, or an emergency.
constexpr std::size_t kLeastRoom = SoeHeader::kSize + wire::Emergency::kSize;

/// Highest count of remaining fragments in the one before the last: some masters include the fragment that they send.
constexpr std::uint16_t kLastLeft = 2;

SoeHeader answer_to(const SoeHeader& request) noexcept {
  auto answer = request;
  answer.op_code = request.op_code == SoeOpCode::kReadRequest ? SoeOpCode::kReadResponse : SoeOpCode::kWriteResponse;
  answer.error = false;
  return answer;
}

std::size_t send(const SoeHeader& header, std::span<const std::byte> data, std::span<std::byte> out) noexcept {
  header.encode(out.first<SoeHeader::kSize>());
  std::copy(data.begin(), data.end(), out.begin() + SoeHeader::kSize);
  return SoeHeader::kSize + data.size();
}

std::size_t send_message(std::uint8_t drive, const SoeCommandChange& change, std::span<std::byte> out) noexcept {
  const SoeHeader header{SoeOpCode::kNotification, false, false, drive, wire::SoeElement::kState, change.idn.raw};
  return send(header, bytes::to_le_bytes(static_cast<std::uint16_t>(change.state)), out);
}

std::size_t send_message(std::uint8_t drive, const wire::Emergency& emergency, std::span<std::byte> out) noexcept {
  std::array<std::byte, wire::Emergency::kSize> data{};
  emergency.encode(data);
  return send({SoeOpCode::kEmergency, false, false, drive, {}, 0}, data, out);
}

}  // namespace

void SoeServer::stop() noexcept {
  write_.reset();
  reading_.reset();
}

std::size_t SoeServer::refuse(const SoeHeader& request, SoeError code, std::span<std::byte> out) {
  auto answer = answer_to(request);
  answer.error = true;
  return send(answer, bytes::to_le_bytes(static_cast<std::uint16_t>(code)), out);
}

tl::expected<std::size_t, MailboxErrorCode> SoeServer::request(const MailboxRequest& request,
                                                               std::span<std::byte> out) {
  const auto header = SoeHeader::decode(request.data);
  if (!header) return tl::unexpected(MailboxErrorCode::kSizeTooShort);
  if (out.size() < kLeastRoom) return tl::unexpected(MailboxErrorCode::kNoMoreMemory);
  const auto data = request.data.subspan(SoeHeader::kSize);
  const bool reads = header->op_code == SoeOpCode::kReadRequest && !header->incomplete;
  const bool writes = header->op_code == SoeOpCode::kWriteRequest;
  if (header->error || (!reads && !writes)) return tl::unexpected(MailboxErrorCode::kInvalidHeader);
  if (reads) {
    write_.reset();
    return read(*header, request.state, out);
  }
  if (!header->incomplete) return write(*header, data, request.state, out);
  collect(*header, data);
  return 0;
}

std::size_t SoeServer::read(const SoeHeader& request, AlState state, std::span<std::byte> out) {
  if (!parameters_->has_drive(request.drive)) return refuse(request, SoeError::kNoDrive, out);
  if (request.elements.bits == 0) return refuse(request, SoeError::kNoElement, out);
  Reading reading{answer_to(request)};
  for (const auto element : wire::kSoeElements) {
    if (!request.elements.has(element)) continue;
    const auto bytes = parameters_->read_element({request.drive, request.idn(), element, state});
    if (!bytes) return refuse(request, bytes.error(), out);
    reading.data.insert(reading.data.end(), bytes->begin(), bytes->end());
  }
  reading_ = std::move(reading);
  return send_part(out);
}

std::size_t SoeServer::send_part(std::span<std::byte> out) {
  const auto room = out.size() - SoeHeader::kSize;
  const auto rest = std::span<const std::byte>(reading_->data).subspan(reading_->sent);
  auto header = reading_->header;
  header.incomplete = rest.size() > room;
  if (header.incomplete) header.value = static_cast<std::uint16_t>((rest.size() - 1) / room);
  const auto length = std::min(rest.size(), room);
  const auto sent = send(header, rest.first(length), out);
  reading_->sent += length;
  if (!header.incomplete) reading_.reset();
  return sent;
}

/// Stores a fragment before the last one. Errors are reported when the last one arrives.
void SoeServer::collect(const SoeHeader& request, std::span<const std::byte> data) {
  if (!write_) {
    write_ = Write{request.drive, request.elements, request.value};
  } else {
    const bool follows =
        write_->drive == request.drive && write_->elements == request.elements && request.value + 1 == write_->left;
    if (!follows && !write_->refusal) write_->refusal = SoeError::kGeneral;
    write_->left = request.value;
  }
  if (write_->refusal) return;
  if (data.size() > kLargest - write_->data.size()) {
    write_->refusal = SoeError::kValueTooLong;
    write_->data.clear();
    return;
  }
  write_->data.insert(write_->data.end(), data.begin(), data.end());
}

std::size_t SoeServer::write(const SoeHeader& request, std::span<const std::byte> data, AlState state,
                             std::span<std::byte> out) {
  auto refusal = std::optional<SoeError>{};
  std::vector<std::byte> whole;
  if (auto begun = std::exchange(write_, std::nullopt)) {
    refusal = begun->refusal;
    const bool follows =
        begun->drive == request.drive && begun->elements == request.elements && begun->left <= kLastLeft;
    if (!follows && !refusal) refusal = SoeError::kGeneral;
    whole = std::move(begun->data);
  }
  whole.insert(whole.end(), data.begin(), data.end());
  if (whole.size() > kLargest) refusal = SoeError::kValueTooLong;
  if (refusal) return refuse(request, *refusal, out);
  const auto written = write_whole(request, whole, state);
  return written ? send(answer_to(request), {}, out) : refuse(request, written.error(), out);
}

SoeAnswer<void> SoeServer::write_whole(const SoeHeader& request, std::span<const std::byte> data, AlState state) {
  if (!parameters_->has_drive(request.drive)) return tl::unexpected(SoeError::kNoDrive);
  if (request.elements.bits == 0) return tl::unexpected(SoeError::kNoElement);
  if (request.elements.count() != 1) return tl::unexpected(SoeError::kGeneral);
  const auto element = static_cast<wire::SoeElement>(request.elements.bits);
  return parameters_->write_element({request.drive, request.idn(), element, state}, data);
}

std::size_t SoeServer::unsolicited(std::span<std::byte> out) {
  if (out.size() < kLeastRoom) return 0;
  if (reading_) return send_part(out);
  const auto message = parameters_->next_message();
  if (!message) return 0;
  return std::visit([&](const auto& content) { return send_message(message->drive, content, out); }, message->content);
}

}  // namespace driveline::slaves
