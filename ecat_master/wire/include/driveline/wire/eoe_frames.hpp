#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "driveline/wire/eoe.hpp"

namespace driveline::wire {

/// Longest Ethernet frame for EoE, in bytes without check sequence: a VLAN tag and 1500 bytes of payload.
inline constexpr std::size_t kMaxEoeFrame = 1518;
/// Shortest Ethernet frame for EoE, in bytes: destination, source, type.
inline constexpr std::size_t kMinEoeFrame = 14;

/// Cuts Ethernet frames into EoE fragments (ETG.1000.6 5.7.2). Counts the frames, so each slave needs its own
/// fragmenter. No allocation.
class EoeFragmenter {
 public:
  /// Bytes of a frame that fit into each fragment but the last, in a mailbox with `room` bytes behind its header; 0:
  /// none.
  [[nodiscard]] static constexpr std::size_t fragment_size(std::size_t room) noexcept {
    if (room < EoeHeader::kSize) return 0;
    return (room - EoeHeader::kSize) / EoeFragment::kBlock * EoeFragment::kBlock;
  }

  /// Starts with `frame`, which must be valid until done(). Returns false and changes nothing when the frame is longer
  /// than kMaxEoeFrame or shorter than kMinEoeFrame. \rtsafe
  [[nodiscard]] constexpr bool begin(std::span<const std::byte> frame, std::uint8_t port = 0) noexcept {
    if (frame.size() < kMinEoeFrame || frame.size() > kMaxEoeFrame) return false;
    rest_ = frame;
    port_ = port;
    number_ = 0;
    offset_ = 0;
    frame_ = (frame_ + 1) & 0x0FU;
    return true;
  }
  /// Whether no fragment is left. \rtsafe
  [[nodiscard]] constexpr bool done() const noexcept { return rest_.empty(); }
  /// Writes the next fragment, header included, into `out`, the service data of a mailbox message; returns its length.
  /// Returns 0 when done, when `out` has no room for a block, or when the frame would take more than 64 fragments.
  /// \rtsafe
  [[nodiscard]] constexpr std::size_t next(std::span<std::byte> out) noexcept {
    const auto most = fragment_size(out.size());
    if (rest_.empty() || most == 0 || number_ > 63) return 0;
    const bool last = rest_.size() <= out.size() - EoeHeader::kSize;
    const auto length = last ? rest_.size() : most;
    const auto blocks = (number_ == 0 ? rest_.size() + EoeFragment::kBlock - 1 : offset_) / EoeFragment::kBlock;
    EoeHeader header;
    header.port = port_;
    header.last_fragment = last;
    header.value = EoeFragment{number_, static_cast<std::uint8_t>(blocks), frame_}.value();
    header.encode(out.first<EoeHeader::kSize>());
    std::copy_n(rest_.begin(), length, out.begin() + EoeHeader::kSize);
    rest_ = rest_.subspan(length);
    offset_ += length;
    ++number_;
    return EoeHeader::kSize + length;
  }
  /// Abandons the frame; the receiver detects it when the next frame starts. \rtsafe
  constexpr void abandon() noexcept { rest_ = {}; }

 private:
  std::span<const std::byte> rest_;
  std::size_t offset_ = 0;
  std::uint8_t port_ = 0;
  std::uint8_t number_ = 0;
  std::uint8_t frame_ = 0;
};

/// Counters of an EoeAssembler.
struct EoeAssembly {
  std::uint64_t frames = 0;     ///< complete frames
  std::uint64_t fragments = 0;  ///< fragments of any frame
  std::uint64_t lost = 0;       ///< frames abandoned because a fragment was missing or another frame started
  std::uint64_t malformed = 0;  ///< fragments with invalid or contradictory sizes and offsets
  std::uint64_t stray = 0;      ///< fragments that belong to no frame in progress
  constexpr bool operator==(const EoeAssembly&) const = default;
};

/// Assembles Ethernet frames from the EoE fragments of a single sender. A fragment that does not continue the frame in
/// progress costs only that frame. No allocation.
class EoeAssembler {
 public:
  /// Takes a fragment: `header` of type kFragment, and the data behind it. Returns the frame when it is complete, valid
  /// until the next call; empty otherwise. \rtsafe
  [[nodiscard]] constexpr std::optional<std::span<const std::byte>> take(const EoeHeader& header,
                                                                         std::span<const std::byte> data) noexcept {
    ++seen_.fragments;
    const auto fragment = EoeFragment::from_value(header.value);
    if (fragment.number == 0) {
      if (!begin(fragment)) return malformed();
    } else if (!in_progress_) {
      ++seen_.stray;
      return std::nullopt;
    } else if (fragment.number != next_ || fragment.frame != frame_) {
      ++seen_.lost;
      in_progress_ = false;
      return std::nullopt;
    } else if (std::size_t{fragment.blocks} * EoeFragment::kBlock != length_) {
      return malformed();
    }
    const bool stamped = header.last_fragment && header.time_appended;
    if (stamped && data.size() < EoeHeader::kTimeStampSize) return malformed();
    if (stamped) data = data.first(data.size() - EoeHeader::kTimeStampSize);
    return append(header, data);
  }
  /// Discards the frame in progress, after the sender was disconnected. \rtsafe
  constexpr void reset() noexcept { in_progress_ = false; }
  /// Number of fragments still missing in the frame in progress if they are as long as the previous ones; 0: no frame
  /// in progress. \rtsafe
  [[nodiscard]] constexpr std::size_t missing() const noexcept {
    return in_progress_ ? ((size_ - length_) * next_ + length_ - 1) / length_ : 0;
  }
  /// Counters since construction. \rtsafe
  [[nodiscard]] constexpr const EoeAssembly& seen() const noexcept { return seen_; }

 private:
  [[nodiscard]] constexpr bool begin(EoeFragment fragment) noexcept {
    if (in_progress_) ++seen_.lost;
    size_ = std::size_t{fragment.blocks} * EoeFragment::kBlock;
    frame_ = fragment.frame;
    next_ = 0;
    length_ = 0;
    in_progress_ = size_ != 0 && size_ < kMaxEoeFrame + EoeFragment::kBlock;
    return in_progress_;
  }
  [[nodiscard]] constexpr std::optional<std::span<const std::byte>> append(const EoeHeader& header,
                                                                           std::span<const std::byte> data) noexcept {
    const bool fits = length_ + data.size() <= std::min(size_, kMaxEoeFrame);
    const bool whole_blocks = data.size() % EoeFragment::kBlock == 0 && !data.empty();
    if (!fits || (!header.last_fragment && !whole_blocks)) return malformed();
    std::copy(data.begin(), data.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(length_));
    length_ += data.size();
    ++next_;
    if (!header.last_fragment) return std::nullopt;
    if (length_ + EoeFragment::kBlock <= size_ || length_ < kMinEoeFrame) return malformed();
    in_progress_ = false;
    ++seen_.frames;
    return std::span<const std::byte>(bytes_).first(length_);
  }
  [[nodiscard]] constexpr std::optional<std::span<const std::byte>> malformed() noexcept {
    ++seen_.malformed;
    in_progress_ = false;
    return std::nullopt;
  }

  std::array<std::byte, kMaxEoeFrame> bytes_{};
  std::size_t size_ = 0;    ///< size of the frame, rounded up to whole blocks, in bytes
  std::size_t length_ = 0;  ///< bytes received so far
  std::uint8_t frame_ = 0;
  std::uint8_t next_ = 0;  ///< number of the expected fragment
  bool in_progress_ = false;
  EoeAssembly seen_;
};

}  // namespace driveline::wire
