#pragma once

#include <gtest/gtest.h>

#include <string_view>
#include <variant>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_client.hpp"
#include "driveline/wire/mailbox.hpp"
#include "scripted_mailbox.hpp"
#include "support/bytes.hpp"

namespace driveline::ecat_master_test {

/// The slave at position 3, with mailboxes of these sizes whose content the test defines, and the master's client for
/// it. Messages are service data of one protocol; the bench adds headers and counters.
struct MailBench {
  using Bytes = std::vector<std::byte>;

  MailBench(wire::MailboxType type, std::uint16_t out, std::uint16_t in,
            const ecat_master::MailboxTimeouts& timeouts = {})
      : protocol(type),
        slave(in),
        bus(slave),
        mailbox(bus, {3, 0x1004}, {ScriptedMailbox::kOut, out, ScriptedMailbox::kIn, in, timeouts}) {}

  /// A mailbox message: length, address 0, channel 0, type, counter; then the service.
  Bytes mail(std::string_view service) { return mail(service, protocol); }
  Bytes mail(std::string_view service, wire::MailboxType type) {
    const auto data = bytes_test::hex(service);
    counter = static_cast<std::uint8_t>(counter % 7 + 1);
    Bytes bytes{static_cast<std::byte>(data.size() & 0xFFU), static_cast<std::byte>(data.size() >> 8)};
    bytes.resize(5);
    bytes.push_back(static_cast<std::byte>(unsigned{counter} << 4U | static_cast<unsigned>(type)));
    bytes.insert(bytes.end(), data.begin(), data.end());
    return bytes;
  }
  /// Queues these messages, one after the other, as the answer to the next request.
  void answer_next(const std::vector<std::string_view>& services) {
    std::vector<Bytes> mails;
    for (const auto service : services) mails.push_back(mail(service));
    slave.answers.push_back(mails);
  }
  /// Queues an answer for each of the next requests; empty: none.
  void answer(const std::vector<std::string_view>& services) {
    for (const auto service : services) {
      if (service.empty()) {
        slave.answers.emplace_back();
      } else {
        answer_next({service});
      }
    }
  }
  /// Requests received by the slave, without mailbox headers.
  [[nodiscard]] std::vector<Bytes> told() const {
    std::vector<Bytes> services;
    for (const auto& request : slave.requests) services.emplace_back(request.begin() + 6, request.end());
    return services;
  }

  wire::MailboxType protocol;
  ScriptedMailbox slave;
  ecat_master::Bus bus;
  ecat_master::MailboxClient mailbox;
  std::uint8_t counter = 0;
};

/// The facts of a failure; fails the test where the result is none, or a failure of another kind.
template <typename Facts, typename Value>
[[nodiscard]] Facts facts_of(const ecat_master::Result<Value>& result) {
  if (!result && result.error().template is<Facts>()) return std::get<Facts>(result.error().facts);
  ADD_FAILURE() << (result ? "success" : describe(result.error()));
  return {};
}

}  // namespace driveline::ecat_master_test
