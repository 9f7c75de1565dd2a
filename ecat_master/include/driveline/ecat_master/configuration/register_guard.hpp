#pragma once

#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/dc/line_clocks.hpp"

namespace driveline::ecat_master {

/// How a register is repaired that has changed while its slave is in OP.
enum class RegisterRepair : std::uint8_t {
  kRewrite,      ///< written again: it takes effect without the slave's application
  kReconfigure,  ///< the application checks it on the way to OP, so the slave is taken up once more (ETG.1000.6 5.3)
};

/// One register, or field of an FMMU or sync manager, that has been written and must keep its value.
struct GuardedRegister {
  std::uint16_t address = 0;                             ///< of the register, or of the first byte of the field
  std::uint8_t size = 0;                                 ///< bytes, up to 8
  RegisterRepair repair = RegisterRepair::kReconfigure;  ///< how it is repaired
  std::uint64_t expected = 0;                            ///< value that was written, little endian bytes as a number
  std::uint64_t bits = ~std::uint64_t{0};                ///< bits that are compared; the others belong to the slave
};

/// A register that no longer has the value it was set to.
struct RegisterChange {
  GuardedRegister guarded;             ///< the register and its expected value
  std::optional<std::uint64_t> found;  ///< none: it could not be read
};

/// Some of the changes cannot be undone while the slave is in OP.
[[nodiscard]] bool needs_configuration(std::span<const RegisterChange> changes) noexcept;

/// "FMMU 1 (0x0610): logical start address is 0x00010020, 0x00010000 was configured". Allocates.
[[nodiscard]] std::string describe(const RegisterChange& change);

/// Properties of a slave's controller and registers that are not part of a plan: read once, when the slave is
/// configured. A register that it does not answer is not guarded.
struct ControllerFacts {
  std::uint8_t fmmus = 0;                              ///< how many it has (0x0004)
  std::uint8_t sync_managers = 0;                      ///< how many it has (0x0005)
  std::optional<std::uint32_t> dl_control;             ///< register 0x0100
  std::optional<std::uint16_t> watchdog_divider;       ///< register 0x0400
  std::optional<std::uint16_t> watchdog_pdi;           ///< register 0x0410
  std::optional<std::uint16_t> watchdog_process_data;  ///< register 0x0420
  std::optional<std::uint16_t> filter_depths;          ///< registers 0x0934 and 0x0935
  constexpr bool operator==(const ControllerFacts&) const = default;
};

/// The facts of all `slaves`, read until two answers agree, because a damaged answer would be used from then on.
/// Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<ControllerFacts>> read_controller_facts(Bus& bus, std::span<const SlaveRef> slaves);

/// All registers of a slave in SAFEOP or OP that the master has written, ascending by address: write protection, DL
/// control, watchdogs, FMMUs, sync managers and, where `clocks` is not null, its distributed clock as far as the line
/// depends on it. Bits that the controller or the mailbox change by themselves do not count.
[[nodiscard]] std::vector<GuardedRegister> guarded_registers(const ConfiguredSlave& slave, const ProcessImage& image,
                                                             const dc::LineClocks* clocks,
                                                             const ControllerFacts& facts);

/// Reads `guarded` back in as few datagrams as they fit into and returns those that differ. A register that differs is
/// read once more and counts only when the value is the same again, because the answer may have been damaged on its
/// way. Errors: WorkingCounter when not exactly one slave answers to the address (`received` of them), those of the
/// bus. Not real-time safe.
[[nodiscard]] Result<std::vector<RegisterChange>> find_changes(Bus& bus, SlaveRef slave,
                                                               std::span<const GuardedRegister> guarded);

/// Writes registers back whose repair is kRewrite; write protection first, in the frame that unlocks it. Errors:
/// WorkingCounter, those of the bus. Not real-time safe.
[[nodiscard]] Result<void> rewrite(Bus& bus, SlaveRef slave, std::span<const RegisterChange> changes);

}  // namespace driveline::ecat_master
