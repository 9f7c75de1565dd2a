#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"

namespace driveline::ecat_master_test {

/// A slave with two mailboxes whose content the test defines: to the slave at 0x1800 (sync manager 0), from the slave
/// at 0x1C00 (sync manager 1, status 0x080D). Every exchange takes 10 us.
class ScriptedMailbox final : public ecat_master::DatagramExchange {
 public:
  static constexpr std::uint16_t kOut = 0x1800;
  static constexpr std::uint16_t kIn = 0x1C00;
  static constexpr std::uint16_t kInStatus = 0x080D;

  explicit ScriptedMailbox(std::size_t in_bytes) : in_bytes_(in_bytes) {}

  /// Mailbox messages written by the master, cut to header and service.
  std::vector<std::vector<std::byte>> requests;
  /// Mailbox messages that answer the n-th request, including the header, one after the other.
  std::deque<std::vector<std::vector<std::byte>>> answers;
  /// If set, called instead of using `answers`.
  std::function<std::vector<std::byte>()> endless;
  /// Number of writes that find the mailbox full before one is accepted.
  int busy = 0;

  ecat_master::Result<void> exchange(std::span<ecat_master::Request> list) override {
    now_ += std::chrono::microseconds{10};
    for (auto& request : list) serve(request);
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  void serve(ecat_master::Request& request) {
    request.answered = true;
    request.working_counter = 1;
    const auto address = request.address.ado();
    if (request.command == wire::Command::kFpwr && address == kOut) {
      if (busy > 0) {
        --busy;
        request.working_counter = 0;
        return;
      }
      const auto length = bytes::load_le<std::uint16_t>(request.data) + std::size_t{6};
      requests.emplace_back(request.data.begin(), request.data.begin() + static_cast<std::ptrdiff_t>(length));
      if (answers.empty()) return;
      for (auto& mail : answers.front()) waiting_.push_back(std::move(mail));
      answers.pop_front();
    } else if (request.command == wire::Command::kFprd && address == kInStatus) {
      if (endless && waiting_.empty()) waiting_.push_back(endless());
      request.data[0] = waiting_.empty() ? std::byte{0x00} : std::byte{0x08};
    } else if (request.command == wire::Command::kFprd && address == kIn && !waiting_.empty()) {
      auto mail = std::move(waiting_.front());
      waiting_.pop_front();
      mail.resize(in_bytes_);
      std::copy(mail.begin(), mail.end(), request.data.begin());
    } else {
      request.working_counter = 0;
    }
  }

  std::size_t in_bytes_;
  std::deque<std::vector<std::byte>> waiting_;
  std::chrono::nanoseconds now_{0};
};

}  // namespace driveline::ecat_master_test
