#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace driveline::motion {

/// How necessary a write at start-up is.
enum class WriteNeed : std::uint8_t {
  kMandatory,  ///< a drive that refuses the write ends the start
  kOptional,   ///< a refusal is noted, and the drive decides by its states whether it can work
  kOmitted,    ///< not written
};

/// State in which a start-up SDO is written.
enum class StartupState : std::uint8_t {
  kPreOperational,   ///< before the process data are exchanged (EtherCAT: PREOP)
  kSafeOperational,  ///< inputs are valid, outputs are not used yet (EtherCAT: SAFEOP)
};

/// An SDO to be written at start-up.
struct StartupSdo {
  std::uint16_t index = 0;      ///< object
  std::uint8_t subindex = 0;    ///< sub-index of the entry, or first sub-index with `complete`
  std::vector<std::byte> data;  ///< value in wire format: little endian, as long as the entry
  bool complete = false;        ///< all sub-indices from `subindex` (0 or 1) on
  StartupState in = StartupState::kPreOperational;
  /// kOptional: the entry is read first and written only if it differs, and a refusal is noted.
  WriteNeed need = WriteNeed::kMandatory;
};

}  // namespace driveline::motion
