#include "driveline/ecat_master/cyclic/foreign_frames.hpp"

#include <algorithm>
#include <array>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master {
namespace {

// Bit positions in ForeignFrames::datagram_.
constexpr unsigned kWeightShift = 40;
constexpr unsigned kCommandShift = 32;
constexpr unsigned kAdpShift = 16;

}  // namespace

bool ForeignFrames::note(std::span<const std::byte> frame) noexcept {
  if (harmless_guest(frame)) return false;
  frames_.add();
  auto cursor = wire::DatagramCursor::open(frame);
  if (!cursor || cursor->done()) return true;
  const auto datagram = cursor->next();
  if (!datagram) return true;
  frames_of_masters_.add();
  std::array<std::byte, 8> source{};
  std::copy_n(frame.begin() + 6, 6, source.begin());
  source_.store(bytes::load_le<std::uint64_t>(source), std::memory_order_relaxed);
  const auto& header = datagram->header;
  const auto seen = std::uint64_t{harm_of(header.command, header.address.ado())} << kWeightShift |
                    std::uint64_t{static_cast<std::uint8_t>(header.command)} << kCommandShift |
                    std::uint64_t{header.address.adp()} << kAdpShift | header.address.ado();
  // Store the most serious datagram: a single write matters more than a thousand reads.
  const auto before = datagram_.load(std::memory_order_relaxed);
  if (seen >> kWeightShift >= before >> kWeightShift) datagram_.store(seen, std::memory_order_relaxed);
  return true;
}

OtherMaster ForeignFrames::other_master() const noexcept {
  OtherMaster other;
  other.frames = frames_of_masters_.value();
  const auto source = bytes::to_le_bytes(source_.load(std::memory_order_relaxed));
  std::copy_n(source.begin(), other.source.size(), other.source.begin());
  const auto seen = datagram_.load(std::memory_order_relaxed);
  other.command = static_cast<wire::Command>(seen >> kCommandShift & 0xFFU);
  other.adp = static_cast<std::uint16_t>(seen >> kAdpShift);
  other.ado = static_cast<std::uint16_t>(seen);
  return other;
}

}  // namespace driveline::ecat_master
