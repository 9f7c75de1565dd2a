#pragma once

#include <string_view>

#include "driveline/canopen_wire/frame.hpp"
#include "driveline/canopen_wire/socketcan.hpp"

namespace driveline::canopen {

/// The stream of cannelloni over TCP (cannelloni, doc/tcp_protocol.md, version 1): both ends send a greeting, then
/// frames one behind the other, encoded as in its packets: identifier with flags in big endian, length, for CAN FD
/// flags, data. There is no delimiter.
namespace cannelloni {

/// What each end sends first; there is no zero behind it.
inline constexpr std::string_view kTcpGreeting = "CANNELLONIv1";

/// A frame of the stream.
struct StreamFrame {
  std::array<std::byte, 13> bytes{};  ///< identifier, length, data
  std::size_t size = 0;               ///< bytes of it that are used
  /// The bytes to send. \rtsafe
  [[nodiscard]] constexpr std::span<const std::byte> view() const noexcept { return std::span(bytes).first(size); }
};

/// Encodes a data or remote frame; empty for another one. \rtsafe
[[nodiscard]] constexpr StreamFrame stream_frame_of(const Frame& frame) noexcept {
  StreamFrame out;
  if (!frame.valid()) return out;
  const auto packet = socketcan::packet_of(frame);
  std::copy_n(packet.begin(), 5, out.bytes.begin());  // identifier and length
  const auto payload = frame.payload();
  std::copy(payload.begin(), payload.end(), out.bytes.begin() + 5);
  out.size = 5 + payload.size();
  return out;
}

/// Reads the frames of a stream behind the greeting, byte by byte.
class StreamReader {
 public:
  /// What a byte has led to.
  enum class Event : std::uint8_t {
    kMore,        ///< a frame is not complete yet
    kFrame,       ///< frame() is complete
    kPassedOver,  ///< the end of a frame that is none of a classic bus: CAN FD, or an identifier out of range
    kBroken,      ///< no frame has this length; nothing behind it can be read
  };

  /// Takes the next byte. After kBroken every byte gives kBroken. \rtsafe
  constexpr Event take(std::byte byte) noexcept {
    if (broken_) return Event::kBroken;
    if (size_ < kept_.size()) kept_[size_] = byte;
    ++size_;
    if (size_ < kHead) return Event::kMore;
    if (size_ == kHead) measure();
    if (broken_) return Event::kBroken;
    return size_ < needed_ ? Event::kMore : finish();
  }
  /// The frame that take() has completed. \rtsafe
  [[nodiscard]] constexpr const Frame& frame() const noexcept { return frame_; }

 private:
  static constexpr std::size_t kHead = 5;
  static constexpr std::uint8_t kFd = 0x80;  // in the length: a frame of CAN FD
  static constexpr std::uint8_t kMaxFdLength = 64;

  [[nodiscard]] constexpr std::uint32_t raw() const noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8U | std::to_integer<std::uint32_t>(kept_[i]);
    return value;
  }
  constexpr void measure() noexcept {
    const auto length = std::to_integer<std::uint8_t>(kept_[4]);
    fd_ = (length & kFd) != 0;
    const auto count = static_cast<std::uint8_t>(length & 0x7FU);
    broken_ = count > (fd_ ? kMaxFdLength : Frame::kMaxLength);
    const bool remote = (raw() & socketcan::flag::kRemote) != 0;
    needed_ = kHead + (fd_ ? 1U : 0U) + (remote ? 0U : count);
  }
  constexpr Event finish() noexcept {
    size_ = 0;
    const auto length = std::to_integer<std::uint8_t>(kept_[4]);
    const auto frame = fd_ ? std::nullopt : socketcan::frame_of(raw(), length, std::span(kept_).subspan(kHead));
    if (!frame) return Event::kPassedOver;
    frame_ = *frame;
    return Event::kFrame;
  }

  std::array<std::byte, 13> kept_{};  ///< of a longer frame the first ones
  std::size_t size_ = 0;              ///< bytes of the frame so far
  std::size_t needed_ = kHead;
  bool fd_ = false;
  bool broken_ = false;
  Frame frame_;
};

}  // namespace cannelloni

}  // namespace driveline::canopen
