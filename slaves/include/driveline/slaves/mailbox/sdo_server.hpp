#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::slaves {

/// SDO server of a device: expedited, normal and segmented upload and download (ETG.1000.6 5.6.2). Complete access
/// is refused with 06010004h: the MSD manual (9.1) lists the services without it.
///
/// One transfer at a time, as the protocol has it: a new initiate request ends an unfinished transfer. There is no
/// time-out between segments (the trace in MSD manual 8.2.4 pauses for 16 s).
class SdoServer {
 public:
  /// Longest object this server transfers.
  static constexpr std::size_t kMaxObject = 512;

  SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner);

  /// Handles an SDO request (the bytes behind the CoE header); writes the response (without CoE header) into `out`,
  /// which has at least 16 bytes. Returns its length, 0 for none.
  [[nodiscard]] std::size_t handle(std::span<const std::byte> request, wire::AlState state, std::span<std::byte> out);
  /// Forgets an unfinished transfer.
  void cancel() noexcept { transfer_ = {}; }

 private:
  struct Transfer {
    enum class Kind : std::uint8_t { kNone, kUpload, kDownload };
    Kind kind = Kind::kNone;
    std::uint16_t index = 0;
    std::uint8_t subindex = 0;
    bool toggle = false;
    std::size_t size = 0;      ///< announced complete size
    std::size_t position = 0;  ///< bytes transferred so far
  };

  [[nodiscard]] std::size_t initiate_upload(const wire::SdoHeader& request, wire::AlState state,
                                            std::span<std::byte> out);
  [[nodiscard]] std::size_t upload_segment(wire::SdoSegmentHeader request, std::span<std::byte> out);
  [[nodiscard]] std::size_t initiate_download(const wire::SdoHeader& request, std::span<const std::byte> data,
                                              wire::AlState state, std::span<std::byte> out);
  [[nodiscard]] std::size_t start_download(const wire::SdoHeader& request, std::span<const std::byte> data,
                                           wire::AlState state, std::span<std::byte> out);
  [[nodiscard]] std::size_t download_segment(wire::SdoSegmentHeader request, std::span<const std::byte> data,
                                             wire::AlState state, std::span<std::byte> out);
  [[nodiscard]] std::size_t abort(std::uint16_t index, std::uint8_t subindex, wire::SdoAbort code,
                                  std::span<std::byte> out);
  [[nodiscard]] std::size_t abort_transfer(wire::SdoAbort code, std::span<std::byte> out);

  ObjectDictionary* dictionary_;
  DictionaryOwner* owner_;
  Transfer transfer_;
  std::vector<std::byte> buffer_;
};

}  // namespace driveline::slaves
