#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::slaves {

/// SDO server of a device: expedited, normal and segmented upload and download of entries and, if the device supports
/// complete access, of whole objects (ETG.1000.6 5.6.2). Otherwise complete access is refused with 06010004h.
///
/// Handles one transfer at a time, as the protocol requires: a new initiate request ends an unfinished transfer. There
/// is no time-out between segments (the trace in MSD manual 8.2.4 pauses for 16 s).
class SdoServer {
 public:
  /// Behaviour that the standard does not require.
  struct Options {
    bool complete_access = false;  ///< whole objects in one transfer
    bool fill_sign = false;  ///< unused bytes of an expedited upload of an INTEGER contain its sign instead of zeros
  };

  /// Both references must outlive this. Allocates memory for the longest transfer.
  SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const Options& options);

  /// Handles an SDO request (bytes after the CoE header); writes the response (without CoE header) into `out`, which
  /// has at least 16 bytes. Returns the length of the response, 0 for none.
  [[nodiscard]] std::size_t handle(std::span<const std::byte> request, AccessPhase phase, std::span<std::byte> out);
  /// Discards an unfinished transfer.
  void cancel() noexcept { transfer_ = {}; }
  /// Returns the size in bytes of the longest transfer of this dictionary.
  [[nodiscard]] std::size_t longest() const noexcept { return buffer_.size(); }

 private:
  struct SdoAddress {
    std::uint16_t index = 0;
    std::uint8_t subindex = 0;
    bool complete = false;
  };
  struct Transfer {
    enum class Kind : std::uint8_t { kNone, kUpload, kDownload };
    Kind kind = Kind::kNone;
    SdoAddress address;
    bool toggle = false;
    std::size_t size = 0;      ///< announced complete size
    std::size_t position = 0;  ///< bytes transferred so far
  };

  [[nodiscard]] std::size_t initiate_upload(const wire::SdoHeader& request, AccessPhase phase,
                                            std::span<std::byte> out);
  [[nodiscard]] std::size_t upload_segment(wire::SdoSegmentHeader request, std::span<std::byte> out);
  [[nodiscard]] std::size_t initiate_download(const wire::SdoHeader& request, std::span<const std::byte> data,
                                              AccessPhase phase, std::span<std::byte> out);
  [[nodiscard]] std::size_t start_download(const wire::SdoHeader& request, std::span<const std::byte> data,
                                           AccessPhase phase, std::span<std::byte> out);
  [[nodiscard]] static std::size_t confirm_download(const SdoAddress& address, std::span<std::byte> out);
  [[nodiscard]] std::size_t download_segment(wire::SdoSegmentHeader request, std::span<const std::byte> data,
                                             AccessPhase phase, std::span<std::byte> out);
  [[nodiscard]] SdoResult<std::size_t> read(const SdoAddress& address, AccessPhase phase);
  /// Returns the filler of the unused bytes after a value of `size` bytes read from this address.
  [[nodiscard]] std::byte filler(const SdoAddress& address, std::size_t size) const noexcept;
  /// Returns the maximum number of bytes of a download to this address.
  [[nodiscard]] SdoResult<std::size_t> capacity(const SdoAddress& address, AccessPhase phase) const;
  [[nodiscard]] SdoResult<void> store(const SdoAddress& address, AccessPhase phase, std::span<const std::byte> data,
                                      bool size_known);
  [[nodiscard]] std::size_t abort(std::uint16_t index, std::uint8_t subindex, wire::SdoAbort code,
                                  std::span<std::byte> out);
  [[nodiscard]] std::size_t abort_transfer(wire::SdoAbort code, std::span<std::byte> out);

  ObjectDictionary* dictionary_;
  DictionaryOwner* owner_;
  bool complete_access_;
  bool fill_sign_;
  Transfer transfer_;
  std::vector<std::byte> buffer_;
};

}  // namespace driveline::slaves
