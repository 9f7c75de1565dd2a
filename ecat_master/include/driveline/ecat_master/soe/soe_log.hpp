#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// A change of the data state of a procedure command.
struct SoeNotification {
  wire::Idn idn;                  ///< the command
  wire::SoeCommandState state{};  ///< its data state
  bool operator==(const SoeNotification&) const = default;
};

/// An unsolicited message of a drive, and the time at which it was fetched.
struct SoeRecord {
  std::uint16_t slave = 0;                                 ///< position on the line
  std::uint8_t drive = 0;                                  ///< drive of the slave
  std::chrono::nanoseconds time{0};                        ///< time on the master's clock
  std::variant<SoeNotification, wire::Emergency> message;  ///< as the slave sent it
};

/// "drive 0: data state of S-0-0099 is 0x0003 (executed)".
[[nodiscard]] std::string describe_message(const SoeRecord& record);
/// Like describe_message(), preceded by time and slave: "3.201 s slave 4 drive 0: ...".
[[nodiscard]] std::string describe(const SoeRecord& record);

/// The newest notifications and emergencies of all slaves: the handler of unsolicited SoE messages
/// (MailboxEngine::handle()). May be used by any thread; not \rtsafe.
class SoeLog final : public MailboxProtocolHandler {
 public:
  /// Most records stored; the oldest is dropped first.
  static constexpr std::size_t kMaxRecords = 256;

  /// Stores the message if it is a notification or an emergency.
  void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) override;
  [[nodiscard]] bool is_request(std::span<const std::byte> service) const noexcept override;
  /// Removes and returns the stored records, oldest first.
  [[nodiscard]] std::vector<SoeRecord> take();
  /// Number of records dropped unread.
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  mutable std::mutex mutex_;
  std::deque<SoeRecord> records_;
  std::uint64_t dropped_ = 0;
};

}  // namespace driveline::ecat_master
