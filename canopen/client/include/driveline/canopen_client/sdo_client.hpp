#pragma once

#include "driveline/canopen_client/bus_link.hpp"
#include "driveline/canopen_client/sdo_transfer.hpp"

namespace driveline::canopen {

/// Reads and writes objects of one node, and waits for the result. Frames of other nodes that arrive meanwhile go to
/// the listener of the link. Not for the cycle; a master uses SdoTransfer.
class SdoClient {
 public:
  /// The link must outlive this. `node`: 1 to 127.
  SdoClient(BusLink& link, std::uint8_t node, const SdoOptions& options = {});

  /// Reads an object. Errors: any of ClientErrorKind.
  [[nodiscard]] ClientResult<std::vector<std::byte>> upload(SdoObject object);
  /// Reads an object of up to four bytes as a number, little endian. Errors: as upload(); kBadAnswer with
  /// kLengthTooHigh when there are more bytes.
  [[nodiscard]] ClientResult<std::uint32_t> upload_number(SdoObject object);
  /// Writes an object. Errors: as upload().
  [[nodiscard]] ClientResult<void> download(SdoObject object, std::span<const std::byte> data);
  /// Writes a number of 1 to 4 bytes.
  [[nodiscard]] ClientResult<void> download_number(SdoObject object, std::uint32_t value, std::size_t bytes);

  /// The node-ID.
  [[nodiscard]] std::uint8_t node() const noexcept { return node_; }
  /// Changes the settings of the transfers that follow.
  void set_options(const SdoOptions& options) noexcept { options_ = options; }
  /// The settings.
  [[nodiscard]] const SdoOptions& options() const noexcept { return options_; }

 private:
  [[nodiscard]] bool is_answer(const Frame& frame) const noexcept;
  [[nodiscard]] ClientResult<std::vector<std::byte>> run(SdoTransfer& transfer);
  void pass_over_old_answers();
  void send(SdoTransfer& transfer);
  void receive(SdoTransfer& transfer, std::chrono::nanoseconds deadline);

  BusLink* link_;
  std::uint8_t node_;
  SdoOptions options_;
  std::chrono::nanoseconds old_answer_until_{0};  ///< until then an answer to an abandoned transfer may come
};

}  // namespace driveline::canopen
