#pragma once

#include <vector>

#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/slaves/canopen/device_options.hpp"
#include "driveline/slaves/canopen/sdo_block_transfer.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::cia301 {

using canopen::SdoMessage;
using canopen::SdoRequest;

/// SDO server (CiA 301 7.2.4): expedited, segmented and, where the device has it, block transfer. One transfer at a
/// time: a new initiate request ends an unfinished one and is answered for its own object. There is no time-out between
/// segments (the trace in MSD manual 8.2.4 pauses for 16 s). Allocates only when it is constructed.
class SdoServer {
 public:
  /// Both references must outlive this.
  SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const DeviceOptions& options);

  /// Handles the payload of a request; returns the answer, or nothing where there is none: an abort, a segment within a
  /// sub-block. A payload with fewer than 8 bytes is ignored and counted.
  [[nodiscard]] std::optional<SdoBytes> handle(std::span<const std::byte> request, AccessPhase phase);
  /// The next segment of a block upload, which needs no request; empty: none is due.
  [[nodiscard]] std::optional<SdoBytes> next_segment() noexcept;
  /// Ends an unfinished transfer, without an answer. \rtsafe
  void cancel() noexcept { kind_ = Kind::kNone; }
  /// Requests that were ignored. \rtsafe
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }

 private:
  enum class Kind : std::uint8_t { kNone, kUpload, kDownload, kBlockUpload, kBlockDownload };

  [[nodiscard]] SdoBytes initiate_upload(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoBytes upload_segment(std::byte command);
  [[nodiscard]] SdoBytes initiate_download(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoBytes download_segment(std::span<const std::byte> request, AccessPhase phase);
  [[nodiscard]] std::optional<SdoBytes> block_upload(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoBytes initiate_block_upload(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoBytes block_download(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoBytes initiate_block_download(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoResult<std::size_t> download_room(const SdoMessage& request, AccessPhase phase);
  [[nodiscard]] SdoResult<void> store(std::span<const std::byte> data, AccessPhase phase, bool size_known = true);
  [[nodiscard]] std::byte filler(std::size_t size) const noexcept;
  [[nodiscard]] SdoBytes abort(SdoAbort code) noexcept;

  ObjectDictionary* dictionary_;
  DictionaryOwner* owner_;
  bool block_transfer_;
  bool size_indicated_;
  bool cut_expedited_;
  bool fill_sign_;
  std::vector<std::byte> buffer_;
  Kind kind_ = Kind::kNone;
  Address address_;
  bool toggle_ = false;
  std::size_t size_ = 0;      ///< of an upload; of a download as announced, or 0
  std::size_t position_ = 0;  ///< bytes transferred so far
  SdoBlockDownload block_down_;
  SdoBlockUpload block_up_;
  std::uint64_t ignored_ = 0;
};

}  // namespace driveline::slaves::cia301
