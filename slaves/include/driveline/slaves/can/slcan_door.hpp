#pragma once

#include "driveline/slaves/can/door.hpp"

namespace driveline::slaves::can {

/// A client that speaks the protocol of serial CAN adapters (LAWICEL AB, CANUSB manual; known as slcan), as if it had
/// an adapter of its own. Its controller takes part in the bus while the channel is open.
///
/// Commands: Sn, sxxyy, O, L, C, t, T, r, R, F, V, N, Zn, X1; the answer to another one, or to one that is not possible
/// now, is BEL. Frames are passed on as they come (auto poll), so A and P are not needed, and there is no acceptance
/// filter. Error frames do not exist in this protocol.
class SlcanDoor final : public Door {
 public:
  static constexpr std::size_t kLongestLine = 64;  ///< longer lines are refused as a whole

  SlcanDoor() { line_.reserve(kLongestLine); }

  void input(std::string_view bytes, nanoseconds now) override;
  void receive(const Frame& frame, nanoseconds now) override;

 private:
  enum class Answer : std::uint8_t { kOk, kError, kGiven };

  void restart() override;
  void execute();
  [[nodiscard]] Answer obey(char command, std::string_view arguments);
  [[nodiscard]] Answer open_channel(bool listen_only);
  [[nodiscard]] Answer close_channel();
  [[nodiscard]] Answer set_bit_rate(std::uint32_t bit_rate);
  [[nodiscard]] Answer transmit();
  [[nodiscard]] Answer status_flags();

  std::string line_;
  bool too_long_ = false;  ///< the line so far
  bool channel_open_ = false;
  bool time_stamps_ = false;
};

}  // namespace driveline::slaves::can
