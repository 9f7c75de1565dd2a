#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/mailbox/mailbox_window.hpp"

namespace driveline::ecat_master_test {

/// Slaves with two mailboxes each, by station address. Every exchange takes 10 us.
class MailLine final : public ecat_master::DatagramExchange {
 public:
  using Bytes = std::vector<std::byte>;
  static constexpr std::uint16_t kLength = 80;  ///< length of a mailbox: two blocks of 32 bytes fit into a fragment
  static constexpr ecat_master::MailboxWindow kWindow{0x1800, kLength, 0x1C00, kLength};

  struct Slave {
    std::vector<Bytes> heard;                   ///< messages from the master, cut to header and service
    std::deque<Bytes> says;                     ///< messages to the master, including the header
    std::function<void(const Bytes&)> answers;  ///< called with every message from the master
    int busy = 0;              ///< number of writes that find the mailbox full before one is accepted; -1: all
    int lost_reads = 0;        ///< number of mailbox reads whose answer is lost
    std::uint8_t counter = 0;  ///< counter of the last message made by say()
    int reads = 0;             ///< number of reads of the mailbox
    int looks = 0;             ///< number of reads of the mailbox status
    Bytes last{};              ///< last message that was read
    bool repeat = false;       ///< value of the last repeat request that was answered

    /// Queues a message of protocol `type` to the master.
    void say(unsigned type, std::span<const std::byte> service) {
      counter = wire::next_mailbox_counter(counter);
      Bytes mail(6);
      mail[0] = static_cast<std::byte>(service.size());
      mail[5] = static_cast<std::byte>(unsigned{counter} << 4 | type);
      mail.insert(mail.end(), service.begin(), service.end());
      says.push_back(std::move(mail));
    }
  };

  Slave& operator[](std::uint16_t station) { return slaves_[station]; }

  ecat_master::Result<void> exchange(std::span<ecat_master::Request> list) override {
    now_ += std::chrono::microseconds{10};
    for (auto& request : list) serve(request, slaves_[request.address.adp()]);
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  void serve(ecat_master::Request& request, Slave& slave) {
    request.answered = true;
    request.working_counter = 1;
    const bool write = request.command == wire::Command::kFpwr;
    const auto address = request.address.ado();
    if (write && address == kWindow.out_address) {
      if (slave.busy != 0) {
        slave.busy -= slave.busy > 0 ? 1 : 0;
        request.working_counter = 0;
        return;
      }
      const auto length = bytes::load_le<std::uint16_t>(request.data) + std::size_t{6};
      slave.heard.emplace_back(request.data.begin(), request.data.begin() + static_cast<std::ptrdiff_t>(length));
      if (slave.answers) slave.answers(slave.heard.back());
    } else if (!write && address == kWindow.in_address) {
      read(request, slave);
    } else if (address == 0x080D) {
      ++slave.looks;
      request.data[0] = slave.says.empty() ? std::byte{0x00} : std::byte{0x08};
      if (request.data.size() == 3) {
        request.data[1] = slave.repeat ? std::byte{0x03} : std::byte{0x01};
        request.data[2] = slave.repeat ? std::byte{0x02} : std::byte{0x00};
      }
    } else if (write && address == 0x080E) {
      slave.repeat = (request.data[0] & std::byte{0x02}) != std::byte{0};
      slave.says.push_front(slave.last);
    }
  }

  static void read(ecat_master::Request& request, Slave& slave) {
    ++slave.reads;
    if (slave.says.empty()) {
      request.working_counter = 0;
    } else {
      slave.last = slave.says.front();
      slave.says.pop_front();
      auto mail = slave.last;
      mail.resize(kLength);
      std::copy(mail.begin(), mail.end(), request.data.begin());
    }
    if (slave.lost_reads == 0) return;
    --slave.lost_reads;
    request.working_counter = 0;
    request.answered = !request.once;
  }

  std::map<std::uint16_t, Slave> slaves_;
  std::chrono::nanoseconds now_{0};
};

}  // namespace driveline::ecat_master_test
