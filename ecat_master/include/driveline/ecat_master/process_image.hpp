#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/wire/endian.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master {

/// Process data one slave contributes, in bytes.
struct ProcessDataDemand {
  std::size_t output_bytes = 0;
  std::size_t input_bytes = 0;
};

/// Where the process data of one slave lies. Outputs and inputs share the same logical bytes (LRW: the slave takes
/// its outputs out of the frame and puts its inputs in), each from `offset` on.
struct ProcessDataPlace {
  std::size_t offset = 0;   ///< byte in ProcessImage::outputs() and inputs()
  std::size_t segment = 0;  ///< the datagram that carries it
  std::size_t output_bytes = 0;
  std::size_t input_bytes = 0;
};

/// A stretch of the image that one LRW datagram carries.
struct ProcessSegment {
  std::size_t offset = 0;
  std::size_t bytes = 0;
  std::uint16_t expected_working_counter = 0;  ///< sum over the FMMUs of its slaves: read 1, write 2 (ETG.1000.4 5.4)
};

/// An entry of the process image: one load or store in the cycle. Made by ProcessImage at start-up.
template <wire::WireInteger T>
class PdoEntry {
 public:
  PdoEntry() = default;
  explicit PdoEntry(std::size_t offset) noexcept : offset_(offset) {}
  /// \rtsafe
  [[nodiscard]] T get(std::span<const std::byte> image) const noexcept {
    return wire::load_le<T>(image.subspan(offset_, sizeof(T)));
  }
  /// \rtsafe
  void set(std::span<std::byte> image, T value) const noexcept {
    wire::store_le<T>(image.subspan(offset_, sizeof(T)), value);
  }

 private:
  std::size_t offset_ = 0;
};

/// The process data of the whole line and its cut into datagrams.
class ProcessImage {
 public:
  /// Logical address of the first byte.
  static constexpr std::uint32_t kLogicalStart = 0x0001'0000;
  /// Bytes beside the LRW that the first cyclic frame must have room for: BRD of the AL status (2) and the drift
  /// compensation datagram (8), with their headers.
  static constexpr std::size_t kReservedBytes = 2 * wire::DatagramHeader::kOverhead + 2 + 8;
  static constexpr std::size_t kMaxSegmentBytes = wire::kMaxDatagramData - kReservedBytes;

  ProcessImage() = default;

  /// Places the slaves one behind the other, none cut in two. Error: kProcessDataSize for a slave that fits no frame.
  [[nodiscard]] static Result<ProcessImage> lay_out(std::span<const ProcessDataDemand> demands);

  [[nodiscard]] std::span<std::byte> outputs() noexcept { return outputs_; }
  [[nodiscard]] std::span<const std::byte> outputs() const noexcept { return outputs_; }
  [[nodiscard]] std::span<std::byte> inputs() noexcept { return inputs_; }
  [[nodiscard]] std::span<const std::byte> inputs() const noexcept { return inputs_; }
  /// By position of the slave on the line.
  [[nodiscard]] std::span<const ProcessDataPlace> places() const noexcept { return places_; }
  [[nodiscard]] std::span<const ProcessSegment> segments() const noexcept { return segments_; }
  [[nodiscard]] static constexpr std::uint32_t logical_address(std::size_t offset) noexcept {
    return kLogicalStart + static_cast<std::uint32_t>(offset);
  }

 private:
  std::vector<std::byte> outputs_;
  std::vector<std::byte> inputs_;
  std::vector<ProcessDataPlace> places_;
  std::vector<ProcessSegment> segments_;
};

/// Time the cyclic frames occupy a 100 Mbit/s wire, in nanoseconds: preamble, header, payload (60 bytes at least),
/// FCS and gap, 80 ns a byte; plus `slave_delay_ns` for each slave's forwarding (there and back).
[[nodiscard]] std::uint64_t wire_time_ns(const ProcessImage& image, std::size_t slaves, std::uint64_t slave_delay_ns);

}  // namespace driveline::ecat_master
