#pragma once

#include "driveline/slaves/canopen/device_options.hpp"
#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

/// A PDO that the device receives (1400h, 1600h and following; CiA 301 7.2.2). Allocates only when it is constructed.
class Rpdo {
 public:
  /// What became of a frame.
  enum class Result : std::uint8_t {
    kForeign,   ///< it is not of this PDO
    kWaits,     ///< it is applied at the next SYNC, or in the next cycle of PDOs
    kApplied,   ///< the values are in the dictionary
    kTooShort,  ///< fewer bytes than mapped: not used
  };

  /// Everything must outlive this. `number` counts from 0.
  Rpdo(ObjectDictionary& dictionary, DictionaryOwner& owner, std::size_t number, const DeviceOptions& options);

  /// Reads communication parameters and mapping again, and forgets a frame that waits. \rtsafe
  void restart() noexcept;
  /// Whether an entry of 14xxh may have this value. Error: kValueRange. \rtsafe
  [[nodiscard]] SdoResult<void> check(const EntryRow& row, std::uint32_t raw) const noexcept;
  /// The mapping or the communication parameters have changed. \rtsafe
  void written(const EntryRow& row) noexcept;
  /// Takes a frame while the device is operational. \rtsafe
  [[nodiscard]] Result receive(const Frame& frame) noexcept;
  /// Whether it exists, and maps something. \rtsafe
  [[nodiscard]] bool active() const noexcept { return active_; }
  /// Identifier of its frames. \rtsafe
  [[nodiscard]] canopen::Identifier identifier() const noexcept { return identifier_; }
  /// Whether the frame is one of this PDO. \rtsafe
  [[nodiscard]] bool is(const Frame& frame) const noexcept {
    return active_ && frame.identifier == identifier_ && frame.kind == canopen::FrameKind::kData;
  }
  /// Whether it waits for a SYNC. \rtsafe
  [[nodiscard]] bool synchronous() const noexcept { return synchronous_; }
  /// A SYNC, or the cycle of PDOs: applies the newest frame that waits for it; false: there is none. \rtsafe
  bool apply() noexcept;
  /// Whether the last frame had more bytes than mapped. \rtsafe
  [[nodiscard]] bool too_long() const noexcept { return too_long_; }

 private:
  void decode(const Frame& frame) noexcept;

  ObjectDictionary* dictionary_;
  DictionaryOwner* owner_;
  const DeviceOptions* options_;
  std::uint16_t mapping_index_;
  Entry cob_id_;
  Entry type_;
  PdoMap map_;
  canopen::Identifier identifier_;
  bool active_ = false;  ///< exists, and maps something
  bool synchronous_ = false;
  bool waits_ = false;
  bool settings_ = false;  ///< are mapped
  bool too_long_ = false;
  Frame newest_;             ///< waits
  std::uint32_t syncs_ = 0;  ///< since the first frame that waits
};

}  // namespace driveline::slaves::cia301
