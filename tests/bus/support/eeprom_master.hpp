#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::bus_test {

/// A master that knows its slaves by their EEPROMs alone: it has no description file and reads no object. It is written
/// from the standards, and shares neither the codec nor the EEPROM decoder with driveline's master and slaves, so a
/// common error of theirs does not cancel out here.
///
/// Order of use: scan(), then request() with PREOP, SAFEOP and OP. All times are on the clock of the port.
class EepromMaster {
 public:
  /// Values of AL control and AL status (ETG.1000.6 Tables 9 and 10).
  static constexpr std::uint16_t kInit = 1;
  static constexpr std::uint16_t kPreOp = 2;
  static constexpr std::uint16_t kSafeOp = 4;
  static constexpr std::uint16_t kOp = 8;
  static constexpr std::uint16_t kError = 0x10;  ///< error in AL status, acknowledge in AL control

  /// A sync manager as category 41 describes it (ETG.1000.6 Table 23); request() writes `length` as it stands here.
  struct SyncManager {
    std::uint16_t start = 0;   ///< address in the memory of the slave
    std::uint16_t length = 0;  ///< bytes; of the PDOs, where PDOs name the sync manager
    std::uint8_t control = 0;  ///< content of the control register
    bool enable = false;       ///< the EEPROM enables the sync manager
    std::uint8_t use = 0;      ///< 1 mailbox out, 2 mailbox in, 3 outputs, 4 inputs
    std::size_t bits = 0;      ///< sum of the entries of its PDOs
  };
  /// An entry of a PDO (ETG.1000.6 Table 25) at its place in the process data of a sync manager.
  struct Entry {
    std::uint16_t index = 0;
    std::uint8_t subindex = 0;
    std::uint8_t sync_manager = 0;
    std::size_t bit = 0;   ///< first bit in the process data of the sync manager
    std::size_t bits = 0;  ///< length
  };
  /// Content of an EEPROM, and what follows from it.
  struct Slave {
    std::uint32_t vendor_id = 0;
    std::uint32_t product_code = 0;
    std::vector<SyncManager> sync_managers;
    std::vector<std::uint8_t> fmmus;  ///< category 40: 1 outputs, 2 inputs, 3 state of the mailbox
    std::vector<Entry> entries;
    std::vector<std::size_t> logical;   ///< by sync manager: first byte in the image
    std::uint16_t working_counter = 0;  ///< expected contribution to the working counter of LRW
  };
  /// What a slave shows after request().
  struct AlAnswer {
    std::uint16_t status = 0;
    std::uint16_t code = 0;  ///< AL status code
  };

  EepromMaster(port::Port& port, rt::Clock& clock) : port_(port), clock_(clock) {}

  /// Counts the slaves, gives them station addresses and reads their EEPROMs.
  void scan();
  /// Requests a state of a slave. Writes the sync managers of the mailboxes between INIT and PREOP, those of the
  /// process data and the FMMUs between PREOP and SAFEOP. Exchanges process data while it waits for OP. `acknowledge`:
  /// with the error bit.
  AlAnswer request(std::size_t slave, std::uint16_t state, bool acknowledge = false);
  /// Requests a state of all slaves in their order; returns the first refusal as a sentence, empty without one.
  [[nodiscard]] std::string request_all(std::uint16_t state);
  /// Exchanges the process data of all slaves with one LRW; returns the working counter.
  std::uint16_t exchange();
  /// Exchanges process data with a period of a millisecond; returns the number of wrong working counters.
  std::size_t run(std::size_t cycles, const std::function<void()>& after_each = {});

  [[nodiscard]] std::vector<Slave>& slaves() noexcept { return slaves_; }
  /// Sum of Slave::working_counter.
  [[nodiscard]] std::uint16_t expected_working_counter() const noexcept;
  /// Returns an input of the last exchange.
  [[nodiscard]] std::uint64_t get(std::size_t slave, std::uint16_t index, std::uint8_t subindex) const;
  /// Sets an output of the next exchange.
  void set(std::size_t slave, std::uint16_t index, std::uint8_t subindex, std::uint64_t value);

 private:
  using Bytes = std::vector<std::uint8_t>;

  /// Exchanges a datagram; returns its working counter, and its data in `data`.
  std::uint16_t transfer(std::uint8_t command, std::uint32_t address, Bytes& data);
  Bytes read(std::size_t slave, std::uint16_t address, std::size_t length);
  void write(std::size_t slave, std::uint16_t address, Bytes data);
  [[nodiscard]] std::uint16_t read_eeprom_word(std::size_t slave, std::uint32_t word);
  [[nodiscard]] Slave read_eeprom(std::size_t slave);
  void write_sync_managers(std::size_t slave, bool mailboxes);
  /// Gives the sync managers with process data places in the image, and writes the FMMUs.
  void write_fmmus(std::size_t slave);
  void pause();
  [[nodiscard]] std::size_t first_bit(std::size_t slave, const Entry& entry) const;
  [[nodiscard]] const Entry& find(std::size_t slave, std::uint16_t index, std::uint8_t subindex) const;

  port::Port& port_;
  rt::Clock& clock_;
  std::uint8_t frame_index_ = 0;
  std::vector<Slave> slaves_;
  Bytes image_;  ///< outputs to send, and inputs as received
};

}  // namespace driveline::bus_test
