#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/process_data/pdo_entry.hpp"
#include "driveline/esi/device_description.hpp"
#include "driveline/wire/command.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master {

/// The process data of one sync manager of a slave.
struct ProcessDataChannel {
  bool output = false;               ///< written by the master; else read
  std::uint8_t sync_manager = 0;     ///< its number
  std::uint16_t physical_start = 0;  ///< address of its buffer in the slave
  std::size_t bytes = 0;             ///< length of its buffer; 0: it has no process data now
  /// Whether both are equal except for the address in the slave's memory.
  [[nodiscard]] constexpr bool same_place(const ProcessDataChannel& other) const noexcept {
    return output == other.output && sync_manager == other.sync_manager && bytes == other.bytes;
  }
};

/// The process data of one slave, and the features of its controller.
struct ProcessDataDemand {
  std::vector<ProcessDataChannel> channels;  ///< in the order of their sync managers
  std::size_t group = 0;                     ///< number of its group
  bool lrw = true;                           ///< false: takes its outputs by LWR and gives its inputs by LRD only
  std::size_t fmmus = 8;                     ///< the slave has (register 0x0004)
  /// Use of each FMMU by the slave's description: a mapping takes a free one for its use if there is one, else an
  /// unused one, else any.
  std::vector<esi::FmmuUse> fmmu_uses{};
  bool al_status = false;            ///< its AL status is wanted in the image, if an FMMU is left
  std::uint16_t mailbox_status = 0;  ///< address of a sync manager status byte wanted in the image likewise; 0: none

  /// Sum over the output channels.
  [[nodiscard]] std::size_t output_bytes() const noexcept { return bytes(true); }
  /// Sum over the input channels.
  [[nodiscard]] std::size_t input_bytes() const noexcept { return bytes(false); }

 private:
  [[nodiscard]] std::size_t bytes(bool output) const noexcept;
};

/// How outputs and inputs of a slave share the logical address space.
enum class ImageLayout : std::uint8_t {
  kOverlapped,  ///< LRW, both in the same logical bytes: the slave takes its outputs out and puts its inputs in
  kSequential,  ///< LRW, inputs behind the outputs
  kSeparate,    ///< LWR for outputs, LRD for inputs
};

/// Slaves that are exchanged together, with a working counter of their own.
struct GroupSettings {
  std::uint32_t divider = 1;  ///< exchanged in every n-th cycle
  std::uint32_t phase = 0;    ///< of those cycles: cycle % divider == phase
  /// After that many exchanges in a row without a complete working counter the group's outputs are sent as zeros until
  /// CyclicCore::release_outputs(); 0: never.
  std::uint32_t bad_cycle_limit = 0;
  /// \rtsafe
  [[nodiscard]] constexpr bool due(std::uint64_t cycle) const noexcept { return cycle % divider == phase; }
};

/// Layout settings of the application.
struct LayoutSettings {
  ImageLayout layout = ImageLayout::kOverlapped;  ///< of all slaves but those without LRW: kSeparate
  std::vector<GroupSettings> groups;              ///< groups without an entry are exchanged in every cycle
};

/// Where the process data of one slave lie. Offsets are bytes of ProcessImage::outputs() and inputs().
struct ProcessDataPlace {
  /// An offset or datagram that does not exist.
  static constexpr std::size_t kNone = SIZE_MAX;

  std::size_t output_offset = 0;         ///< of outputs()
  std::size_t output_bytes = 0;          ///< 0: no outputs
  std::size_t input_offset = 0;          ///< of inputs()
  std::size_t input_bytes = 0;           ///< 0: no inputs
  std::size_t group = 0;                 ///< number of its group
  std::size_t output_datagram = kNone;   ///< the datagram that carries the outputs
  std::size_t input_datagram = kNone;    ///< the same for inputs and status bytes
  std::size_t al_status_offset = kNone;  ///< input byte: low byte of the AL status (register 0x0130)
  std::size_t mailbox_offset = kNone;    ///< input byte: status of the mailbox sync manager
};

/// A stretch of the image that one datagram carries.
struct ProcessDatagram {
  wire::Command command = wire::Command::kLrw;  ///< LRW, LRD or LWR
  std::size_t group = 0;                        ///< number of its group
  std::size_t frame = 0;                        ///< number of the frame it travels in
  std::size_t offset = 0;                       ///< of the image, in bytes, the same for outputs and inputs
  std::size_t bytes = 0;                        ///< length of its data
  /// Sum over the slaves whose FMMUs touch it: a read counts 1, a write 1, or 2 in an LRW (ETG.1000.4 5.4.1.2).
  std::uint16_t expected_working_counter = 0;
};

/// Share of one slave in the working counter of one datagram.
struct WorkingCounterShare {
  std::size_t datagram = 0;  ///< number in ProcessImage::datagrams()
  std::size_t slave = 0;     ///< position on the line
  std::uint16_t count = 0;   ///< increment when it takes part
};

/// The process data of the whole line, its cut into datagrams and frames, and the FMMUs that follow from it. No slave's
/// outputs or inputs are cut in two.
class ProcessImage {
 public:
  /// Logical address of the first byte.
  static constexpr std::uint32_t kLogicalStart = 0x0001'0000;
  /// Bytes beside the process data that the first cyclic frame must have room for: BRD of the AL status (2) and the
  /// drift compensation datagram (8), with their headers.
  static constexpr std::size_t kReservedBytes = 2 * wire::DatagramHeader::kOverhead + 2 + 8;
  /// Longest datagram that fits into the first frame beside these.
  static constexpr std::size_t kMaxDatagramBytes = wire::kMaxDatagramData - kReservedBytes;

  ProcessImage() = default;

  /// Places the slaves group by group. Errors: ProcessDataSize for a slave that fits no frame, TooFewFmmus for one
  /// whose process data need more than it has.
  [[nodiscard]] static Result<ProcessImage> lay_out(std::span<const ProcessDataDemand> demands,
                                                    const LayoutSettings& settings = {});

  /// Outputs that the next cycle sends. Belong to the cycle once it runs. \rtsafe
  [[nodiscard]] std::span<std::byte> outputs() noexcept { return outputs_; }
  /// The outputs, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> outputs() const noexcept { return outputs_; }
  /// Newest inputs; those of a missing slave keep their last values. Belong to the cycle once it runs. \rtsafe
  [[nodiscard]] std::span<std::byte> inputs() noexcept { return inputs_; }
  /// The inputs, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> inputs() const noexcept { return inputs_; }
  /// By position of the slave on the line.
  [[nodiscard]] std::span<const ProcessDataPlace> places() const noexcept { return places_; }
  /// In the order of their frames. \rtsafe
  [[nodiscard]] std::span<const ProcessDatagram> datagrams() const noexcept { return datagrams_; }
  /// In the order of the datagrams.
  [[nodiscard]] std::span<const WorkingCounterShare> shares() const noexcept { return shares_; }
  /// By number of the group. \rtsafe
  [[nodiscard]] std::span<const GroupSettings> groups() const noexcept { return groups_; }
  /// Frames when all groups are due. \rtsafe
  [[nodiscard]] std::size_t frame_count() const noexcept { return frame_count_; }
  /// The FMMUs of a slave by their number, as they have to be written to it.
  [[nodiscard]] std::span<const wire::FmmuEntity> fmmus(std::size_t slave) const noexcept { return fmmus_[slave]; }
  /// Gives the FMMUs of a slave the addresses of `to`, channels that are those of `from` but for their addresses.
  void relocate(std::size_t slave, std::span<const ProcessDataChannel> from, std::span<const ProcessDataChannel> to);
  /// Of a byte of outputs() or inputs(). \rtsafe
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
  std::vector<GroupSettings> groups_;
  std::vector<std::vector<wire::FmmuEntity>> fmmus_;
  std::size_t frame_count_ = 0;
};

/// Share of a slave with these FMMUs in the working counter of a logical datagram.
[[nodiscard]] std::uint16_t working_counter_share(std::span<const wire::FmmuEntity> fmmus, wire::Command command,
                                                  std::uint32_t logical_start, std::size_t bytes) noexcept;

/// Time the cyclic frames of the busiest cycle occupy a 100 Mbit/s wire, in nanoseconds: preamble, header, payload (60
/// bytes at least), FCS and gap, 80 ns a byte. `clocks`: with the datagram that hands on the reference clock's time.
[[nodiscard]] std::uint64_t wire_time_ns(const ProcessImage& image, bool clocks);

}  // namespace driveline::ecat_master
