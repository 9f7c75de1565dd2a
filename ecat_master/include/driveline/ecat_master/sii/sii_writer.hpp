#pragma once

#include <functional>
#include <string>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Called after each word with the number of changed words done. Returning false stops the writing; the words written
/// so far are then restored.
using SiiProgress = std::function<bool(std::size_t done, std::size_t total)>;

/// A complete, verified write.
struct SiiWriteReport {
  std::size_t words_changed = 0;    ///< words written because they differed
  std::size_t words_unchanged = 0;  ///< words that already had the new value and were not written
  std::vector<std::byte> previous;  ///< previous content of the written range
};

/// A write that failed.
struct SiiWriteFailure {
  Error error;                    ///< cause
  std::size_t words_written = 0;  ///< words written before the failure
  /// Words that may differ from their content before the write, ascending: they could not be restored. Empty: the
  /// content is unchanged.
  std::vector<std::uint16_t> left;
  std::vector<std::byte> previous;  ///< previous content, as far as it was readable
};

/// Writes `image` (a whole number of words, at least the 8 words of the configuration area with its checksum) to the
/// EEPROM of a slave, from word 0 on.
///
/// Only words that differ are written; each is read back, and the whole range again at the end (an EEPROM smaller than
/// the image wraps around). A word that is not acknowledged is written again. When words behind the configuration area
/// change, the checksum is invalidated first and written last: the slave controller then detects an incomplete image,
/// even after a power failure, at its next start (ETG.1000.6 5.4, ESC data sheet "EEPROM checksum"). When a word fails,
/// all words written before are restored in reverse order; the checksum becomes valid last.
///
/// The slave should be in INIT. Values that the slave controller loads from the EEPROM, including the alias, take
/// effect at the next power-on. Errors: SiiBusy, SiiError, SiiVerify, SiiContent (`image` too short or odd), Cancelled,
/// those of the bus. Not real-time safe.
[[nodiscard]] tl::expected<SiiWriteReport, SiiWriteFailure> write_sii(Bus& bus, SlaveRef slave,
                                                                      std::span<const std::byte> image,
                                                                      const SiiProgress& progress = {});

/// Writes the configured station alias (word 4) and the matching checksum. Further error: SiiContent when the checksum
/// of the current configuration area is wrong; nothing is written then.
[[nodiscard]] tl::expected<SiiWriteReport, SiiWriteFailure> write_alias(Bus& bus, SlaveRef slave, std::uint16_t alias);

/// The failure as a sentence: the cause, and the current content of the EEPROM. Allocates: not for the cycle.
[[nodiscard]] std::string describe(const SiiWriteFailure& failure);

/// Reads `count` words starting at word `first`. Takes the EEPROM interface from the slave's application. Errors:
/// SiiBusy, SiiError, those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<std::byte>> read_sii_words(Bus& bus, SlaveRef slave, std::size_t first,
                                                            std::size_t count);

}  // namespace driveline::ecat_master
