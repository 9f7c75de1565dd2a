#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::ecat_master {

/// A CoE emergency and the time at which it was fetched.
struct EmergencyRecord {
  std::uint16_t slave = 0;           ///< position on the line
  std::chrono::nanoseconds time{0};  ///< time on the master's clock
  wire::Emergency message;           ///< as the slave sent it
};

/// "3.201 s slave 4: emergency 0x3220, DC link undervoltage, error register 0x05, 01 00 ...".
[[nodiscard]] std::string describe(const EmergencyRecord& record);

/// The newest emergencies of all slaves: the handler of unsolicited CoE messages (MailboxEngine::handle()). May be used
/// by any thread; not \rtsafe.
class EmergencyLog final : public MailboxProtocolHandler {
 public:
  /// Most emergencies stored per slave; the oldest is dropped first.
  static constexpr std::size_t kMaxPerSlave = 64;

  /// Stores the message if it is an emergency.
  void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) override;
  [[nodiscard]] bool is_request(std::span<const std::byte> service) const noexcept override {
    return wire::is_coe_request(service);
  }
  /// Stores an emergency; drops the oldest one of the slave when there are too many.
  void add(const EmergencyRecord& record);
  /// Removes and returns the emergencies of a slave, oldest first.
  [[nodiscard]] std::vector<EmergencyRecord> take(std::uint16_t slave);
  /// The emergencies of all slaves, oldest first, without removing them.
  [[nodiscard]] std::vector<EmergencyRecord> all() const;
  /// Number of emergencies of a slave that were dropped unread.
  [[nodiscard]] std::uint64_t dropped(std::uint16_t slave) const;

 private:
  struct Slave {
    std::deque<EmergencyRecord> records;
    std::uint64_t dropped = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::uint16_t, Slave> slaves_;
};

}  // namespace driveline::ecat_master
