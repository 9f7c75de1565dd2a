#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::slaves {

/// SDO server of a device: expedited, normal and segmented upload and download of entries and, when the device has
/// complete access, of whole objects (ETG.1000.6 5.6.2). Without it complete access is refused with 06010004h.
///
/// One transfer at a time, as the protocol has it: a new initiate request ends an unfinished transfer. There is no
/// time-out between segments (the trace in MSD manual 8.2.4 pauses for 16 s).
class SdoServer {
 public:
  /// What the device does beyond and otherwise than the standard's least.
  struct Options {
    bool complete_access = false;  ///< whole objects in one transfer
    bool fill_sign = false;  ///< unused bytes of an expedited upload of an INTEGER carry its sign instead of zeros
  };

  /// Both must outlive this. Allocates room for the longest transfer.
  SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const Options& options);

  /// Handles an SDO request (the bytes behind the CoE header); writes the response (without CoE header) into `out`,
  /// which has at least 16 bytes. Returns its length, 0 for none.
  [[nodiscard]] std::size_t handle(std::span<const std::byte> request, AccessPhase phase, std::span<std::byte> out);
  /// Forgets an unfinished transfer.
  void cancel() noexcept { transfer_ = {}; }
  /// Bytes of the longest transfer of this dictionary.
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
  /// What fills up the value of `size` bytes that was read from this address.
  [[nodiscard]] std::byte filler(const SdoAddress& address, std::size_t size) const noexcept;
  /// The most bytes a download to this address takes.
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
