#pragma once

#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/dc/line_clocks.hpp"

namespace driveline::ecat_master {

/// How to repair a register that has changed while its slave is in OP.
enum class RegisterRepair : std::uint8_t {
  kRewrite,      ///< write it again: it takes effect without the slave's application
  kReconfigure,  ///< reconfigure the slave, because its application checks it on the way to OP (ETG.1000.6 5.3)
};

/// A register, or a field of an FMMU or sync manager, that the master wrote and that must keep its value.
struct GuardedRegister {
  std::uint16_t address = 0;                             ///< address of the register, or of the first byte of the field
  std::uint8_t size = 0;                                 ///< bytes, up to 8
  RegisterRepair repair = RegisterRepair::kReconfigure;  ///< repair method
  std::uint64_t expected = 0;                            ///< value that was written, little endian bytes as a number
  std::uint64_t bits = ~std::uint64_t{0};                ///< bits to compare; the others belong to the slave
};

/// A register that no longer has the expected value.
struct RegisterChange {
  GuardedRegister guarded;             ///< the register and its expected value
  std::optional<std::uint64_t> found;  ///< value found; empty: unreadable
};

/// Whether some of the changes can only be repaired by reconfiguring the slave.
[[nodiscard]] bool needs_configuration(std::span<const RegisterChange> changes) noexcept;

/// "FMMU 1 (0x0610): logical start address is 0x00010020, 0x00010000 was configured". Allocates.
[[nodiscard]] std::string describe(const RegisterChange& change);

/// Properties of a slave's controller and registers that are not part of a plan: read once, when the slave is
/// configured. A register that the slave does not answer is not guarded.
struct ControllerFacts {
  std::uint8_t fmmus = 0;                              ///< number of FMMUs (0x0004)
  std::uint8_t sync_managers = 0;                      ///< number of sync managers (0x0005)
  std::optional<std::uint32_t> dl_control;             ///< register 0x0100
  std::optional<std::uint16_t> watchdog_divider;       ///< register 0x0400
  std::optional<std::uint16_t> watchdog_pdi;           ///< register 0x0410
  std::optional<std::uint16_t> watchdog_process_data;  ///< register 0x0420
  std::optional<std::uint16_t> filter_depths;          ///< registers 0x0934 and 0x0935
  constexpr bool operator==(const ControllerFacts&) const = default;
};

/// Reads the facts of all `slaves`, until two answers agree, because a damaged answer would be used permanently.
/// Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<ControllerFacts>> read_controller_facts(Bus& bus, std::span<const SlaveRef> slaves);

/// All registers of a slave in SAFEOP or OP that the master has written, ascending by address: write protection, DL
/// control, watchdogs, FMMUs, sync managers and, where `clocks` is not null, the settings of its distributed clock that
/// the line depends on. Bits that the controller or the mailbox change themselves are not compared.
[[nodiscard]] std::vector<GuardedRegister> guarded_registers(const ConfiguredSlave& slave, const ProcessImage& image,
                                                             const dc::LineClocks* clocks,
                                                             const ControllerFacts& facts);

/// Reads back `guarded` in as few datagrams as possible and returns the registers that differ. A register that differs
/// is read again and counts only when the second value is the same, because the answer may have been damaged in
/// transit. Errors: WorkingCounter when not exactly one slave answers to the address (`received` of them), those of the
/// bus. Not real-time safe.
[[nodiscard]] Result<std::vector<RegisterChange>> find_changes(Bus& bus, SlaveRef slave,
                                                               std::span<const GuardedRegister> guarded);

/// Restores registers whose repair is kRewrite; write protection first, in the frame that unlocks it. Errors:
/// WorkingCounter, those of the bus. Not real-time safe.
[[nodiscard]] Result<void> rewrite(Bus& bus, SlaveRef slave, std::span<const RegisterChange> changes);

}  // namespace driveline::ecat_master
