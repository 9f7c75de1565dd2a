#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/slaves/mc7000/sequence_control.hpp"
#include "fake_sequence_drive.hpp"

namespace driveline::slaves::mc7000::test {

// Control words of the manual (lines 937-943), low byte first there.
inline constexpr std::uint16_t kShutDown = 0x0006;
inline constexpr std::uint16_t kManual = 0x084F;
inline constexpr std::uint16_t kAutomatic = 0x085F;
inline constexpr std::uint16_t kStart = 0x087F;

/// A sequence control with its drive, in steps of 0.5 ms.
class SequenceTest : public testing::Test {
 protected:
  static constexpr std::chrono::microseconds kPeriod{500};
  static constexpr double kPeriodMs = 0.5;

  void download(const std::vector<std::string_view>& lines) {
    for (const auto line : lines) {
      const auto taken = control.command(line);
      ASSERT_TRUE(taken) << line << ": " << text_of(taken.error());
    }
  }
  /// Steps for a time with a control word.
  void run_ms(int duration_ms, std::uint16_t word) {
    for (int i = 0; i < duration_ms * 2; ++i) {
      control.step(word, enabled);
      drive.advance(kPeriodMs);
    }
  }
  /// Automatic and start as the manual orders them (line 938), and forgets what the drive was told so far.
  void start_program() {
    run_ms(4, kManual);
    run_ms(12, kAutomatic);
    drive.take();
    run_ms(1, kStart);
  }

  FakeSequenceDrive drive;
  SequenceControl control{drive, kPeriod};
  bool enabled = true;
};

}  // namespace driveline::slaves::mc7000::test
