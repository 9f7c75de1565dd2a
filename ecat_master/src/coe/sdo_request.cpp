#include "driveline/ecat_master/coe/sdo_request.hpp"

#include <algorithm>

#include "driveline/ecat_master/coe/sdo_transfer.hpp"

namespace driveline::ecat_master {

SdoRequest::SdoRequest(std::uint16_t position, std::uint16_t index, std::uint8_t subindex, std::size_t capacity)
    : position_(position), index_(index), subindex_(subindex), buffer_(capacity) {}

bool SdoRequest::start_upload() noexcept {
  const auto now = state();
  if (now == State::kPending || now == State::kBusy) return false;
  download_ = false;
  used_ = 0;
  state_.store(State::kPending, std::memory_order_release);
  return true;
}

bool SdoRequest::start_download(std::span<const std::byte> data) noexcept {
  const auto now = state();
  if (now == State::kPending || now == State::kBusy || data.size() > buffer_.size()) return false;
  std::copy(data.begin(), data.end(), buffer_.begin());
  used_ = data.size();
  download_ = true;
  state_.store(State::kPending, std::memory_order_release);
  return true;
}

std::span<const std::byte> SdoRequest::data() const noexcept {
  if (state() != State::kDone) return {};
  return std::span(buffer_).first(used_);
}

std::shared_ptr<MailboxDialogue> SdoRequest::take() {
  auto expected = State::kPending;
  if (!state_.compare_exchange_strong(expected, State::kBusy, std::memory_order_acq_rel)) return nullptr;
  const SdoAddress at{index_, subindex_, false};
  const auto value = std::span(buffer_).first(used_);
  auto transfer = download_ ? std::make_shared<SdoTransfer>(at, std::vector<std::byte>(value.begin(), value.end()))
                            : std::make_shared<SdoTransfer>(at);
  transfer->on_completion([request = shared_from_this()](const auto& result) { request->finish(result); });
  return transfer;
}

void SdoRequest::finish(const Result<std::vector<std::byte>>& result) noexcept {
  auto next = State::kDone;
  if (!result) {
    error_ = result.error();
    next = State::kFailed;
  } else if (!download_ && result->size() > buffer_.size()) {
    error_ = {facts::SdoSize{.object = {index_, subindex_},
                             .expected = static_cast<std::uint32_t>(buffer_.size()),
                             .received = static_cast<std::uint32_t>(result->size())},
              position_};
    next = State::kFailed;
  } else if (!download_) {
    std::copy(result->begin(), result->end(), buffer_.begin());
    used_ = result->size();
  }
  state_.store(next, std::memory_order_release);
}

std::shared_ptr<SdoRequest> make_request(MailboxEngine& engine, std::uint16_t position, std::uint16_t index,
                                         std::uint8_t subindex, std::size_t capacity) {
  auto request = std::make_shared<SdoRequest>(position, index, subindex, capacity);
  engine.watch(request);
  return request;
}

}  // namespace driveline::ecat_master
