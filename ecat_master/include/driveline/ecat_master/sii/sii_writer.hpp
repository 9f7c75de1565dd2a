#pragma once

#include <functional>
#include <string>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Told after each word how many of the changed words are done. Returning false stops the writing; the words written so
/// far are then restored.
using SiiProgress = std::function<bool(std::size_t done, std::size_t total)>;

/// A write that is complete and has been read back.
struct SiiWriteReport {
  std::size_t words_changed = 0;    ///< written, since they held something else
  std::size_t words_unchanged = 0;  ///< held the wanted value before and were left alone
  std::vector<std::byte> previous;  ///< previous content of the written range
};

/// A write that failed.
struct SiiWriteFailure {
  Error error;                    ///< why
  std::size_t words_written = 0;  ///< before the failure
  /// Words that may hold something else than before the write, ascending: they could not be restored. Empty: the
  /// content is what it was before.
  std::vector<std::uint16_t> left;
  std::vector<std::byte> previous;  ///< previous content, as far as it could be read
};

/// Writes `image` (a whole number of words, at least the 8 words of the configuration area with its checksum) to the
/// EEPROM of a slave, from word 0 on.
///
/// Only words that differ are written; each is read back, and the whole range once more at the end (an EEPROM smaller
/// than the image wraps around). A word that is not acknowledged is tried again. When words behind the configuration
/// area change, the checksum is made invalid first and written last: an image that is cut off half-way, by a power
/// failure even, is found out by the slave controller at its next start (ETG.1000.6 5.4, ESC data sheet "EEPROM
/// checksum") instead of passing for a good one. When a word fails, all words written before are restored in reverse
/// order; the checksum becomes valid last.
///
/// The slave should be in INIT. What the slave controller loads from the EEPROM, the alias included, takes effect with
/// the next power-on. Errors: SiiBusy, SiiError, SiiVerify, SiiContent (`image` too short or odd), Cancelled,
/// those of the bus. Not real-time safe.
[[nodiscard]] tl::expected<SiiWriteReport, SiiWriteFailure> write_sii(Bus& bus, SlaveRef slave,
                                                                      std::span<const std::byte> image,
                                                                      const SiiProgress& progress = {});

/// Writes the configured station alias (word 4) and the checksum that goes with it. Further error: SiiContent when the
/// checksum of the present configuration area is wrong; nothing is written then.
[[nodiscard]] tl::expected<SiiWriteReport, SiiWriteFailure> write_alias(Bus& bus, SlaveRef slave, std::uint16_t alias);

/// The failure as a sentence: why, and what the EEPROM holds now. Allocates: not for the cycle.
[[nodiscard]] std::string describe(const SiiWriteFailure& failure);

/// Reads `count` words from word `first` on. Takes the EEPROM interface from the slave's application. Errors: SiiBusy,
/// SiiError, those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<std::byte>> read_sii_words(Bus& bus, SlaveRef slave, std::size_t first,
                                                            std::size_t count);

}  // namespace driveline::ecat_master
