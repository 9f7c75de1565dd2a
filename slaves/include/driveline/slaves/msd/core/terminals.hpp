#pragma once

#include <array>
#include <cstdint>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Input terminals; the number is the bit in 2079h (MSD manual Table 10.6).
enum class Input : std::uint8_t {
  kEnpo = 0,
  kIsd00 = 1,
  kIsd01 = 2,
  kIsd02 = 3,
  kIsd03 = 4,
  kIsd04 = 5,
  kIsd05 = 6,
  kIsdsh = 7,
  kIsd06 = 16,
  kIsa00 = 18,
  kIsa01 = 19,
};

/// Output terminals; the number is the bit in 208Fh (MSD manual Table 10.7).
enum class Output : std::uint8_t { kOsd00 = 0, kOsd01 = 1, kOsd02 = 2, kBrake = 6, kRelay = 7, kStoRelay = 15 };

/// Functions of inputs, numbers of the selectors P 100-P 110 (Device Help: 5, 6, 10; MSD manual 14.1: 15; the reset's
/// number is ours).
enum class InputFunction : std::uint16_t {
  kOff = 0,
  kFaultReset = 1,
  kPositiveLimit = 5,  ///< LCW
  kNegativeLimit = 6,  ///< LCCW
  kHomeSwitch = 10,    ///< HOMSW
  kProbe = 15,         ///< PROBE, ISD05 and ISD06 only
};

/// Functions of outputs, numbers of the selectors P 122-P 126 (Device Help: 14; MSD manual Table 10.8: 39, 40; the
/// brake's number is ours).
enum class OutputFunction : std::uint16_t {
  kOff = 0,
  kBrake = 1,        ///< P 125 only: energised while the brake is to be open
  kLimit = 14,       ///< a setpoint is at its limit
  kBusEachMs = 39,   ///< 60FEh, once per millisecond
  kBusEachStep = 40  ///< 60FEh, in every control cycle
};

/// Whether the selector `index` (2064h and up for P 100 and up) may be set to this number. \rtsafe
[[nodiscard]] bool valid_input_function(std::uint16_t index, std::uint64_t function) noexcept;
/// Bits of P 120 that are allowed: the hardware enable and safe torque off cannot be inverted (ours).
[[nodiscard]] bool valid_inversion(std::uint64_t inputs) noexcept;
/// See valid_input_function(), for the selectors of outputs. \rtsafe
[[nodiscard]] bool valid_output_function(std::uint16_t index, std::uint64_t function) noexcept;

/// Functions of the inputs, whatever terminal they are assigned to.
struct InputSignals {
  bool positive_limit = false;  ///< some input with kPositiveLimit is on
  bool negative_limit = false;  ///< some input with kNegativeLimit is on
  bool home_switch = false;     ///< some input with kHomeSwitch is on
  bool fault_reset = false;     ///< some input with kFaultReset is on
  std::array<bool, 2> probe{};  ///< ISD05, ISD06 where they are selected as probes
};

/// The drive's digital inputs and outputs with their function selectors.
class Terminals {
 public:
  /// \rtsafe
  void set(Input input, bool level) noexcept;
  /// At the terminal, whatever its function. \rtsafe
  [[nodiscard]] bool level(Input input) const noexcept { return (inputs_ >> static_cast<unsigned>(input) & 1U) != 0; }
  /// At the terminal, whatever its function. \rtsafe
  [[nodiscard]] bool output(Output output) const noexcept {
    return (outputs_ >> static_cast<unsigned>(output) & 1U) != 0;
  }
  /// New function selectors. \rtsafe
  void configure(const ObjectDictionary& dictionary) noexcept;
  /// Present state of the input functions. \rtsafe
  [[nodiscard]] const InputSignals& signals() const noexcept { return signals_; }

  /// P 125 gives the brake's output to the drive's brake control. \rtsafe
  [[nodiscard]] bool controls_brake() const noexcept {
    return output_functions_[kBrakeOutput] == OutputFunction::kBrake;
  }
  /// Power-on: no output is energised. \rtsafe
  void clear_outputs() noexcept { outputs_ = 0; }
  /// Conditions for the outputs in one control cycle.
  struct OutputConditions {
    std::uint32_t physical_outputs = 0;  ///< 60FEh sub 1
    std::uint32_t mask = 0;              ///< 60FEh sub 2
    bool brake_open = false;             ///< the brake is to be open
    bool limit = false;                  ///< a setpoint is at its limit
    bool millisecond = false;            ///< a new period of 1 ms begins
  };
  /// \rtsafe
  void step_outputs(const OutputConditions& conditions) noexcept;

  [[nodiscard]] std::uint32_t input_image() const noexcept { return inputs_; }    ///< 2079h
  [[nodiscard]] std::uint32_t output_image() const noexcept { return outputs_; }  ///< 208Fh
  [[nodiscard]] std::uint32_t function_image() const noexcept;                    ///< 60FDh

 private:
  static constexpr std::size_t kBrakeOutput = 3;  ///< P 125 of P 122-P 126

  void evaluate() noexcept;

  std::uint32_t inputs_ = 0x81;  ///< ENPO and ISDSH connected
  std::uint32_t inverted_ = 0;   ///< P 120
  std::uint32_t outputs_ = 0;
  std::array<InputFunction, 11> input_functions_{};
  std::array<OutputFunction, 5> output_functions_{};
  InputSignals signals_;
};

}  // namespace driveline::slaves::msd
