#pragma once

#include <array>
#include <string>

#include "driveline/canopen_wire/cob_id.hpp"
#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"

namespace driveline::cli {

/// Name of an NMT state, such as "pre-operational"; a number for others.
[[nodiscard]] std::string nmt_state_words(canopen::NmtState state);
/// "0x8130 (life guarding or heartbeat)": codes of CiA 301, else those of CiA 402.
[[nodiscard]] std::string emergency_code_words(std::uint16_t code);
/// An EMCY message as text: code with its name, error register, manufacturer's bytes.
[[nodiscard]] std::string emergency_words(const canopen::Emergency& emergency);
/// Bytes in hexadecimal digits, separated by blanks.
[[nodiscard]] std::string bytes_words(std::span<const std::byte> bytes);

/// A frame in words, by the predefined connection set of CANopen.
struct FrameWords {
  std::string name;       ///< such as "heartbeat node 3"; empty: no identifier of CANopen
  std::string meaning;    ///< such as "pre-operational"; empty: nothing more than its bytes
  std::uint8_t node = 0;  ///< node-ID; 0: of no single node
};

/// Finds the words of the frames of a bus in their order: what an SDO segment is depends on those before.
class FrameReader {
 public:
  /// Reads the next frame.
  [[nodiscard]] FrameWords read(const canopen::Frame& frame);

 private:
  /// Who sends segments of a block, whose first byte is a sequence number.
  enum class Block : std::uint8_t { kNone, kDownload, kUpload };
  struct Transfer {
    Block segments = Block::kNone;
    std::uint8_t last_sequence = 0;  ///< of the last segment that was seen
    bool complete = false;           ///< it was the last one of the transfer
  };

  [[nodiscard]] FrameWords read_sdo(const canopen::Frame& frame, std::uint8_t node, bool request);
  [[nodiscard]] std::string request_meaning(std::span<const std::byte> payload, Transfer& transfer);
  [[nodiscard]] std::string answer_meaning(std::span<const std::byte> payload, Transfer& transfer);

  std::array<Transfer, canopen::kMaxNodeId + 1U> transfers_{};
};

}  // namespace driveline::cli
