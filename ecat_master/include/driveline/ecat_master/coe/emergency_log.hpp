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

/// A CoE emergency and when it was fetched.
struct EmergencyRecord {
  std::uint16_t slave = 0;           ///< position on the line
  std::chrono::nanoseconds time{0};  ///< clock of the master
  wire::Emergency message;           ///< as the slave sent it
};

/// "3.201 s slave 4: emergency 0x3220, DC link undervoltage, error register 0x05, 01 00 ...".
[[nodiscard]] std::string describe(const EmergencyRecord& record);

/// Emergencies of all slaves, the newest of each slave: what CoE does with mails that nobody has asked for
/// (MailboxEngine::handle()). May be used by any thread; not \rtsafe.
class EmergencyLog final : public MailboxProtocolHandler {
 public:
  /// Most emergencies kept of one slave; the oldest goes first.
  static constexpr std::size_t kMaxPerSlave = 64;

  /// Keeps the mail if it is an emergency.
  void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) override;
  /// Keeps one more; the oldest of a slave that has too many goes.
  void add(const EmergencyRecord& record);
  /// Those of one slave, oldest first; they are gone afterwards.
  [[nodiscard]] std::vector<EmergencyRecord> take(std::uint16_t slave);
  /// Those of all slaves, oldest first; they stay.
  [[nodiscard]] std::vector<EmergencyRecord> all() const;
  /// How many of a slave had to go unread.
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
