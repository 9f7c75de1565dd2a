#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/esi/device_description.hpp"
#include "driveline/motion/cia301/image_place.hpp"
#include "driveline/wire/command.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master {

/// The process data of a sync manager.
struct ProcessDataChannel {
  bool output = false;               ///< written by the master; else read
  std::uint8_t sync_manager = 0;     ///< number of the sync manager
  std::uint16_t physical_start = 0;  ///< address of its buffer in the slave
  std::size_t bytes = 0;             ///< length of its buffer; 0: currently no process data
  /// Whether both are equal except for the address in the slave's memory. \rtsafe
  [[nodiscard]] constexpr bool same_place(const ProcessDataChannel& other) const noexcept {
    return output == other.output && sync_manager == other.sync_manager && bytes == other.bytes;
  }
};

/// The process data of a slave, and the features of its controller.
struct ProcessDataDemand {
  std::vector<ProcessDataChannel> channels;  ///< in the order of their sync managers
  std::size_t group = 0;                     ///< number of its group
  bool lrw = true;                           ///< false: supports only LWR for outputs and LRD for inputs
  std::size_t fmmus = 8;                     ///< number of FMMUs in the slave (register 0x0004)
  /// Use of each FMMU according to the slave's description: a mapping takes a free FMMU with the matching use, else an
  /// unused one, else any.
  std::vector<esi::FmmuUse> fmmu_uses{};
  bool al_status = false;  ///< maps the AL status into the image, if an FMMU is left
  std::uint16_t mailbox_status =
      0;  ///< address of a sync manager status byte to map into the image, if an FMMU is left; 0: none

  /// Total size of the output channels in bytes.
  [[nodiscard]] std::size_t output_bytes() const noexcept { return bytes(true); }
  /// Total size of the input channels in bytes.
  [[nodiscard]] std::size_t input_bytes() const noexcept { return bytes(false); }

 private:
  [[nodiscard]] std::size_t bytes(bool output) const noexcept;
};

/// How outputs and inputs of a slave share the logical address space.
enum class ImageLayout : std::uint8_t {
  kOverlapped,  ///< LRW, both in the same logical bytes: the slave replaces its outputs with its inputs
  kSequential,  ///< LRW, inputs behind the outputs
  kSeparate,    ///< LWR for outputs, LRD for inputs
};

/// Slaves that are exchanged together, with a separate working counter.
struct ExchangeGroupSettings {
  std::uint32_t divider = 1;  ///< exchanged in every n-th cycle
  std::uint32_t phase = 0;    ///< phase of the exchange: cycle % divider == phase
  /// After this number of consecutive exchanges with an incomplete working counter, the group's outputs are sent as
  /// zeros until CyclicCore::release_outputs(); 0: never.
  std::uint32_t bad_cycle_limit = 0;
  /// Whether the group is exchanged in this cycle. \rtsafe
  [[nodiscard]] constexpr bool due(std::uint64_t cycle) const noexcept { return cycle % divider == phase; }
};

/// Layout settings of the application.
struct LayoutSettings {
  ImageLayout layout =
      ImageLayout::kOverlapped;               ///< layout of all slaves except those without LRW, which use kSeparate
  std::vector<ExchangeGroupSettings> groups;  ///< groups without an entry are exchanged in every cycle
};

/// Position of a slave's process data. Offsets are bytes in ProcessImage::outputs() and inputs().
struct ProcessDataPlace {
  /// Marks an offset or datagram that does not exist.
  static constexpr std::size_t kNone = SIZE_MAX;

  std::size_t output_offset = 0;        ///< offset in outputs()
  std::size_t output_bytes = 0;         ///< 0: no outputs
  std::size_t input_offset = 0;         ///< offset in inputs()
  std::size_t input_bytes = 0;          ///< 0: no inputs
  std::size_t group = 0;                ///< number of its group
  std::size_t output_datagram = kNone;  ///< datagram that carries the outputs
  std::size_t input_datagram = kNone;   ///< datagram that carries inputs and status bytes
  std::size_t al_status_offset =
      kNone;  ///< offset of the input byte with the low byte of the AL status (register 0x0130)
  std::size_t mailbox_offset = kNone;  ///< offset of the input byte with the status of the mailbox sync manager
  std::uint32_t divider = 1;           ///< divider of its group: it is exchanged in every n-th cycle

  /// What an axis needs of it.
  [[nodiscard]] motion::ImagePlace image_place() const noexcept { return {output_offset, input_offset, divider}; }
};

/// A contiguous part of the image that one datagram carries.
struct ProcessDatagram {
  wire::Command command = wire::Command::kLrw;  ///< LRW, LRD or LWR
  std::size_t group = 0;                        ///< number of its group
  std::size_t frame = 0;                        ///< number of its frame
  std::size_t offset = 0;                       ///< offset in the image in bytes, the same for outputs and inputs
  std::size_t bytes = 0;                        ///< length of its data
  /// Sum over the slaves whose FMMUs overlap it: 1 for a read, 1 for a write, 2 for a write in an LRW (ETG.1000.4
  /// 5.4.1.2).
  std::uint16_t expected_working_counter = 0;
};

/// Share of a slave in the working counter of a datagram.
struct WorkingCounterShare {
  std::size_t datagram = 0;  ///< number in ProcessImage::datagrams()
  std::size_t slave = 0;     ///< position on the line
  std::uint16_t count = 0;   ///< increment when the slave processes the datagram
};

/// The process data of the whole line, their division into datagrams and frames, and the resulting FMMUs. The outputs
/// or inputs of a slave are never split.
class ProcessImage {
 public:
  /// Logical address of the first byte.
  static constexpr std::uint32_t kLogicalStart = 0x0001'0000;
  /// Bytes that the first cyclic frame must provide in addition to the process data: BRD of the AL status (2) and the
  /// drift compensation datagram (8), with their headers.
  static constexpr std::size_t kReservedBytes = 2 * wire::DatagramHeader::kOverhead + 2 + 8;
  /// Longest datagram that fits into the first frame in addition to these.
  static constexpr std::size_t kMaxDatagramBytes = wire::kMaxDatagramData - kReservedBytes;

  ProcessImage() = default;

  /// Places the slaves group by group. Errors: ProcessDataSize for a slave that fits into no frame, TooFewFmmus for a
  /// slave whose process data need more FMMUs than it has.
  [[nodiscard]] static Result<ProcessImage> lay_out(std::span<const ProcessDataDemand> demands,
                                                    const LayoutSettings& settings = {});

  /// Outputs that the next cycle sends. Owned by the cycle while it runs. \rtsafe
  [[nodiscard]] std::span<std::byte> outputs() noexcept { return outputs_; }
  /// The outputs, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> outputs() const noexcept { return outputs_; }
  /// Newest inputs; those of a missing slave keep their last values. Owned by the cycle while it runs. \rtsafe
  [[nodiscard]] std::span<std::byte> inputs() noexcept { return inputs_; }
  /// The inputs, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> inputs() const noexcept { return inputs_; }
  /// Positions of the process data, by position of the slave on the line.
  [[nodiscard]] std::span<const ProcessDataPlace> places() const noexcept { return places_; }
  /// The datagrams, in the order of their frames. \rtsafe
  [[nodiscard]] std::span<const ProcessDatagram> datagrams() const noexcept { return datagrams_; }
  /// The working counter shares, in the order of the datagrams.
  [[nodiscard]] std::span<const WorkingCounterShare> shares() const noexcept { return shares_; }
  /// The groups, by number. \rtsafe
  [[nodiscard]] std::span<const ExchangeGroupSettings> groups() const noexcept { return groups_; }
  /// Number of frames when all groups are due. \rtsafe
  [[nodiscard]] std::size_t frame_count() const noexcept { return frame_count_; }
  /// The FMMUs of a slave by number, as to be written to it.
  [[nodiscard]] std::span<const wire::FmmuEntity> fmmus(std::size_t slave) const noexcept { return fmmus_[slave]; }
  /// Moves the FMMUs of a slave to the addresses of `to`; the channels `to` and `from` must be equal except for their
  /// addresses.
  void relocate(std::size_t slave, std::span<const ProcessDataChannel> from, std::span<const ProcessDataChannel> to);
  /// Logical address of a byte of outputs() or inputs(). \rtsafe
  [[nodiscard]] static constexpr std::uint32_t logical_address(std::size_t offset) noexcept {
    return kLogicalStart + static_cast<std::uint32_t>(offset);
  }

 private:
  class Builder;

  std::vector<std::byte> outputs_;
  std::vector<std::byte> inputs_;
  std::vector<ProcessDataPlace> places_;
  std::vector<ProcessDatagram> datagrams_;
  std::vector<WorkingCounterShare> shares_;
  std::vector<ExchangeGroupSettings> groups_;
  std::vector<std::vector<wire::FmmuEntity>> fmmus_;
  std::size_t frame_count_ = 0;
};

/// Share of a slave with these FMMUs in the working counter of a logical datagram.
[[nodiscard]] std::uint16_t working_counter_share(std::span<const wire::FmmuEntity> fmmus, wire::Command command,
                                                  std::uint32_t logical_start, std::size_t bytes) noexcept;

/// Time for which the cyclic frames of the busiest cycle occupy a 100 Mbit/s wire, in nanoseconds: preamble, header,
/// payload (at least 60 bytes), FCS and gap, 80 ns per byte. `clocks`: with the datagram that distributes the reference
/// clock's time.
[[nodiscard]] std::uint64_t wire_time_ns(const ProcessImage& image, bool clocks);

}  // namespace driveline::ecat_master
