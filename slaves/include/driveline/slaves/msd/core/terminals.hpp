#pragma once

#include <array>
#include <cstdint>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Input terminals, numbered by their bit in 2079h (MSD manual Table 10.6).
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

/// Output terminals, numbered by their bit in 208Fh (MSD manual Table 10.7).
enum class Output : std::uint8_t { kOsd00 = 0, kOsd01 = 1, kOsd02 = 2, kBrake = 6, kRelay = 7, kStoRelay = 15 };

/// Functions of inputs, numbered as in the selectors P 100-P 110 (Device Help: 5, 6, 10; MSD manual 14.1: 15; the
/// number of the reset is ours).
enum class InputFunction : std::uint16_t {
  kOff = 0,
  kFaultReset = 1,
  kPositiveLimit = 5,  ///< LCW
  kNegativeLimit = 6,  ///< LCCW
  kHomeSwitch = 10,    ///< HOMSW
  kProbe = 15,         ///< PROBE, ISD05 and ISD06 only
};

/// Functions of outputs, numbered as in the selectors P 122-P 126 (Device Help: 14; MSD manual Table 10.8: 39, 40; the
/// number of the brake is ours).
enum class OutputFunction : std::uint16_t {
  kOff = 0,
  kBrake = 1,        ///< P 125 only: energised to open the brake
  kLimit = 14,       ///< a setpoint is at its limit
  kBusEachMs = 39,   ///< 60FEh, once per millisecond
  kBusEachStep = 40  ///< 60FEh, in every control cycle
};

/// Whether the selector `index` (2064h and up for P 100 and up) accepts this number. \rtsafe
[[nodiscard]] bool valid_input_function(std::uint16_t index, std::uint64_t function) noexcept;
/// Whether P 120 accepts these bits: hardware enable and safe torque off cannot be inverted (ours).
[[nodiscard]] bool valid_inversion(std::uint64_t inputs) noexcept;
/// Whether the output selector `index` accepts this number. \rtsafe
[[nodiscard]] bool valid_output_function(std::uint16_t index, std::uint64_t function) noexcept;

/// Active functions of the inputs, regardless of their terminals.
struct InputSignals {
  bool positive_limit = false;  ///< an input with kPositiveLimit is active
  bool negative_limit = false;  ///< an input with kNegativeLimit is active
  bool home_switch = false;     ///< an input with kHomeSwitch is active
  bool fault_reset = false;     ///< an input with kFaultReset is active
  std::array<bool, 2> probe{};  ///< ISD05, ISD06 if they are selected as probes
};

/// Digital inputs and outputs of the drive with their function selectors.
class Terminals {
 public:
  /// \rtsafe
  void set(Input input, bool level) noexcept;
  /// Returns the level at the terminal, regardless of its function. \rtsafe
  [[nodiscard]] bool level(Input input) const noexcept { return (inputs_ >> static_cast<unsigned>(input) & 1U) != 0; }
  /// Returns the level at the terminal, regardless of its function. \rtsafe
  [[nodiscard]] bool output(Output output) const noexcept {
    return (outputs_ >> static_cast<unsigned>(output) & 1U) != 0;
  }
  /// Applies new function selectors. \rtsafe
  void configure(const ObjectDictionary& dictionary) noexcept;
  /// Returns the current state of the input functions. \rtsafe
  [[nodiscard]] const InputSignals& signals() const noexcept { return signals_; }

  /// Whether P 125 assigns the brake's output to the brake control of the drive. \rtsafe
  [[nodiscard]] bool controls_brake() const noexcept {
    return output_functions_[kBrakeOutput] == OutputFunction::kBrake;
  }
  /// Whether step_outputs() would change nothing as long as inputs, selectors, brake and 60FEh remain: no output
  /// depends on the limit or the millisecond. \rtsafe
  [[nodiscard]] bool outputs_rest() const noexcept { return (limit_ | bus_each_ms_) == 0; }
  /// Power-on: no output is energised. \rtsafe
  void clear_outputs() noexcept { outputs_ = 0; }
  /// Conditions for the outputs in a control cycle.
  struct OutputConditions {
    std::uint32_t physical_outputs = 0;  ///< 60FEh sub 1
    std::uint32_t mask = 0;              ///< 60FEh sub 2
    bool brake_open = false;             ///< the brake is commanded to open
    bool limit = false;                  ///< a setpoint is at its limit
    bool millisecond = false;            ///< a new period of 1 ms starts
  };
  /// \rtsafe
  void step_outputs(const OutputConditions& conditions) noexcept;

  [[nodiscard]] std::uint32_t input_image() const noexcept { return inputs_; }    ///< 2079h
  [[nodiscard]] std::uint32_t output_image() const noexcept { return outputs_; }  ///< 208Fh
  [[nodiscard]] std::uint32_t function_image() const noexcept;                    ///< 60FDh

 private:
  static constexpr std::size_t kBrakeOutput = 3;  ///< index of P 125 in P 122-P 126

  void evaluate() noexcept;
  void sort_outputs() noexcept;

  InputSignals signals_;
  std::uint32_t inputs_ = 0x81;  ///< initially ENPO and ISDSH are connected
  std::uint32_t inverted_ = 0;   ///< P 120
  std::uint32_t outputs_ = 0;
  std::array<InputFunction, 11> input_functions_{};
  std::array<OutputFunction, 5> output_functions_{};
  // Bits of the outputs by their function, so that a control cycle does not go through the selectors.
  std::uint32_t bus_each_step_ = 0;
  std::uint32_t bus_each_ms_ = 0;
  std::uint32_t limit_ = 0;
  std::uint32_t brake_ = 0;
  std::uint32_t driven_ = UINT32_MAX;  ///< off, limit or brake: set in every control cycle
};

}  // namespace driveline::slaves::msd
