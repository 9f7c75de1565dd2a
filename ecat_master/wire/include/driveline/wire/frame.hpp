#pragma once

#include <algorithm>
#include <optional>

#include "driveline/wire/datagram.hpp"
#include "driveline/wire/ethernet.hpp"

namespace driveline::wire {

/// Number of bytes in front of the first datagram of a frame.
inline constexpr std::size_t kDatagramsOffset = EthernetHeader::kSize + EtherCatHeader::kSize;
/// Most data bytes of a single datagram in one untagged frame: 1500 - 2 - 12.
inline constexpr std::size_t kMaxDatagramData = kMaxPayloadBytes - EtherCatHeader::kSize - DatagramHeader::kOverhead;

/// Position of a datagram in its frame (offsets from the first byte of the Ethernet header).
struct DatagramPlace {
  std::size_t header = 0;  ///< offset of the datagram header in the frame
  std::size_t length = 0;  ///< data bytes
  /// Offset of the data. \rtsafe
  [[nodiscard]] constexpr std::size_t data() const noexcept { return header + DatagramHeader::kSize; }
  /// Offset of the working counter. \rtsafe
  [[nodiscard]] constexpr std::size_t working_counter() const noexcept { return data() + length; }
};

/// Builds one EtherCAT frame in a buffer of the caller, datagram by datagram, without allocation.
///
/// The buffer must hold at least kMinFrameBytes; data and working counters start as zero. \rtsafe throughout.
class FrameBuilder {
 public:
  /// Starts a frame in `buffer`, which must outlive the builder and hold at least the headers. \rtsafe
  constexpr FrameBuilder(std::span<std::byte> buffer, const MacAddress& source,
                         const MacAddress& destination = kBroadcastMac) noexcept
      : buffer_(buffer.first(std::min(buffer.size(), EthernetHeader::kSize + kMaxPayloadBytes))) {
    std::fill(buffer_.begin(), buffer_.end(), std::byte{0});
    EthernetHeader{destination, source, kEtherTypeEtherCat}.encode(buffer_.first<EthernetHeader::kSize>());
  }

  /// Appends a datagram with zeroed data and working counter; empty when it no longer fits.
  constexpr std::optional<DatagramPlace> add(Command command, std::uint8_t index, DatagramAddress address,
                                             std::size_t length) noexcept {
    if (length > DatagramHeader::kMaxLength || end_ + DatagramHeader::kOverhead + length > buffer_.size()) {
      return std::nullopt;
    }
    if (!empty()) {
      buffer_[last_header_ + 7] |= std::byte{0x80};  // "more" flag of the previous datagram
    }
    const DatagramPlace place{end_, length};
    DatagramHeader header;
    header.command = command;
    header.index = index;
    header.address = address;
    header.length = static_cast<std::uint16_t>(length);
    header.encode(buffer_.subspan(place.header).first<DatagramHeader::kSize>());
    end_ = place.working_counter() + DatagramHeader::kWorkingCounterSize;
    last_header_ = place.header;
    return place;
  }

  /// Data of a datagram placed by add(), to be filled in. \rtsafe
  [[nodiscard]] constexpr std::span<std::byte> data(const DatagramPlace& place) noexcept {
    return buffer_.subspan(place.data(), place.length);
  }
  /// Number of data bytes that another datagram may carry.
  [[nodiscard]] constexpr std::size_t room() const noexcept {
    const std::size_t used = end_ + DatagramHeader::kOverhead;
    return used >= buffer_.size() ? 0 : buffer_.size() - used;
  }
  /// Whether no datagram has been added. \rtsafe
  [[nodiscard]] constexpr bool empty() const noexcept { return last_header_ == 0; }

  /// Writes the EtherCAT header and returns the frame, padded to the Ethernet minimum of 60 bytes.
  constexpr std::span<std::byte> finish() noexcept {
    EtherCatHeader{static_cast<std::uint16_t>(end_ - kDatagramsOffset), EtherCatHeader::kTypeCommands}.encode(
        buffer_.subspan(EthernetHeader::kSize).first<EtherCatHeader::kSize>());
    return buffer_.first(std::max(end_, kMinFrameBytes));
  }

 private:
  std::span<std::byte> buffer_;
  std::size_t end_ = kDatagramsOffset;
  std::size_t last_header_ = 0;  ///< offset of the last datagram's header; 0: none yet
};

/// One datagram of a received frame.
template <typename Byte>
struct BasicDatagramView {
  DatagramHeader header;                  ///< as received
  DatagramPlace place;                    ///< position in the frame
  std::span<Byte> data;                   ///< data bytes, as many as the header says
  std::span<Byte> working_counter_bytes;  ///< the two bytes behind the data
  /// The working counter: the sum over the slaves that executed the command. \rtsafe
  [[nodiscard]] constexpr std::uint16_t working_counter() const noexcept {
    return bytes::load_le<std::uint16_t>(working_counter_bytes);
  }
};
/// View of a datagram in a read-only frame.
using DatagramView = BasicDatagramView<const std::byte>;

/// Iterates over the datagrams of a frame. Checks every length against the available bytes before using it.
///
/// \code
/// auto cursor = DatagramCursor::open(frame);            // checks Ethernet and EtherCAT header
/// while (cursor && !cursor->done()) { auto d = cursor->next(); if (!d) break; ... }
/// \endcode
/// \rtsafe throughout.
template <typename Byte>
class BasicDatagramCursor {
 public:
  /// Accepts frames of EtherType 0x88A4, with at most one VLAN tag.
  [[nodiscard]] static constexpr Decoded<BasicDatagramCursor> open(std::span<Byte> frame) noexcept {
    const auto ethernet = EthernetHeader::decode(frame);
    if (!ethernet) return tl::unexpected(ethernet.error());
    std::size_t offset = EthernetHeader::kSize;
    std::uint16_t type = ethernet->ether_type;
    if (type == kEtherTypeVlan) {
      if (frame.size() < offset + 4) return tl::unexpected(DecodeError::kTooShort);
      type = bytes::load_be16(frame.subspan(offset + 2, 2));
      offset += 4;
    }
    if (type != kEtherTypeEtherCat) return tl::unexpected(DecodeError::kNotEtherCat);
    return open_payload(frame, offset);
  }

  /// Like open(), for a frame whose EtherCAT header starts at `offset` (behind a UDP header, for example).
  [[nodiscard]] static constexpr Decoded<BasicDatagramCursor> open_payload(std::span<Byte> frame,
                                                                           std::size_t offset) noexcept {
    if (frame.size() < offset) return tl::unexpected(DecodeError::kTooShort);
    const auto header = EtherCatHeader::decode(frame.subspan(offset));
    if (!header) return tl::unexpected(header.error());
    if (header->type != EtherCatHeader::kTypeCommands) return tl::unexpected(DecodeError::kNotCommands);
    const std::size_t begin = offset + EtherCatHeader::kSize;
    if (header->length > frame.size() - begin) return tl::unexpected(DecodeError::kBadLength);
    return BasicDatagramCursor(frame, begin, begin + header->length);
  }

  /// Whether the last datagram has been returned. \rtsafe
  [[nodiscard]] constexpr bool done() const noexcept { return done_; }

  /// The next datagram. After an error the cursor is done.
  [[nodiscard]] constexpr Decoded<BasicDatagramView<Byte>> next() noexcept {
    done_ = true;
    const auto rest = frame_.subspan(position_, end_ - position_);
    const auto header = DatagramHeader::decode(rest);
    if (!header) return tl::unexpected(header.error());
    if (header->length + DatagramHeader::kOverhead > rest.size()) return tl::unexpected(DecodeError::kBadLength);
    const DatagramPlace place{position_, header->length};
    position_ = place.working_counter() + DatagramHeader::kWorkingCounterSize;
    done_ = !header->more;
    return BasicDatagramView<Byte>{*header, place, frame_.subspan(place.data(), place.length),
                                   frame_.subspan(place.working_counter(), DatagramHeader::kWorkingCounterSize)};
  }

 private:
  constexpr BasicDatagramCursor(std::span<Byte> frame, std::size_t begin, std::size_t end) noexcept
      : frame_(frame), position_(begin), end_(end), done_(begin == end) {}

  std::span<Byte> frame_;
  std::size_t position_;
  std::size_t end_;
  bool done_;
};
/// Cursor for read-only frames.
using DatagramCursor = BasicDatagramCursor<const std::byte>;
/// Cursor for frames that are modified in transit, as slaves do.
using MutableDatagramCursor = BasicDatagramCursor<std::byte>;

}  // namespace driveline::wire
