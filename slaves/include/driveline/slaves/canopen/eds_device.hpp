#pragma once

#include "driveline/slaves/canopen/device.hpp"
#include "driveline/slaves/canopen/eds_model.hpp"
#include "driveline/slaves/generic/generic_device.hpp"

namespace driveline::slaves::cia301 {

/// Options of an individual device.
struct EdsDeviceOptions {
  std::uint8_t node_id = 1;                      ///< 1 to 127
  std::uint32_t bit_rate = 1'000'000;            ///< bit/s
  std::uint32_t serial_number = 0;               ///< 0: that of the file
  bool loop_back = true;                         ///< inputs repeat outputs
  std::vector<generic::ScriptedInput> inputs{};  ///< inputs that follow a script, once a millisecond
};

/// A device simulated from its EDS or DCF: all services whose objects the file has, and a minimal application. Drives
/// of CiA 402 are ideal ones (generic::IdealDrives); with loop-back each mapped input repeats the next mapped output of
/// the same length, both in the order of the PDOs; other inputs follow a script or keep their values.
///
/// Belongs to the thread that advances the bus.
class EdsDevice final : public DeviceSignals, private Application {
 public:
  /// Precondition: every input of `options` belongs to the model.
  EdsDevice(std::shared_ptr<const EdsModel> model, EdsDeviceOptions options);
  EdsDevice(const EdsDevice&) = delete;  // the device refers to the dictionary of this object
  EdsDevice& operator=(const EdsDevice&) = delete;
  ~EdsDevice() override = default;

  /// Returns the node of the bus.
  [[nodiscard]] Device& device() noexcept { return device_; }
  /// Returns the node of the bus, read only.
  [[nodiscard]] const Device& device() const noexcept { return device_; }
  /// Returns the values.
  [[nodiscard]] const ObjectDictionary& dictionary() const noexcept { return dictionary_; }
  /// Switches the device off and on again, with the next advance of the bus.
  void restart() { device_.power_on(); }

  // DeviceSignals: the entries of the default PDOs.
  [[nodiscard]] std::size_t signal_count(Direction direction) const noexcept override {
    return model_->entries(direction).size();
  }
  [[nodiscard]] std::string signal_name(SignalId id) const override {
    return model_->entries(id.direction)[id.number].name;
  }
  [[nodiscard]] tl::expected<SignalId, SignalNameError> find_signal(Direction direction,
                                                                    std::string_view name) const override;
  [[nodiscard]] tl::expected<void, SignalValueError> check_signal_value(std::size_t input, double value) const override;
  void set_signal(std::size_t input, double value) noexcept override;
  [[nodiscard]] double signal(SignalId id) const noexcept override;

 private:
  struct Loop {
    const EntryRow* output = nullptr;
    const EntryRow* input = nullptr;
  };

  // Application
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  [[nodiscard]] bool power_stage_on() const noexcept override { return false; }
  [[nodiscard]] std::uint8_t node_id(Reset reset) override;
  [[nodiscard]] std::uint32_t bit_rate(Reset /*reset*/) override { return options_.bit_rate; }
  void restart(Reset reset, nanoseconds now) override;
  void advance(nanoseconds now) override;
  [[nodiscard]] nanoseconds next_wake() const noexcept override;
  void rpdo_applied(std::size_t number, nanoseconds now) override;

  [[nodiscard]] std::vector<const EntryRow*> mapped(std::uint16_t first, std::size_t pdos) const;
  [[nodiscard]] bool driven(const EntryRow& row) const noexcept;
  void build_loops();
  void loop_back() noexcept;
  void follow_scripts(nanoseconds now) noexcept;

  std::shared_ptr<const EdsModel> model_;
  EdsDeviceOptions options_;
  ObjectDictionary dictionary_;
  generic::IdealDrives drives_;
  bool periodic_;  ///< something changes by itself
  std::vector<Loop> loops_;
  std::vector<const EntryRow*> set_rows_;  ///< inputs set by set_signal(); memory is reserved for all
  nanoseconds start_{0};
  nanoseconds millisecond_{0};  ///< the next one
  bool changed_ = false;        ///< values may differ from the last messages
  Device device_;
};

}  // namespace driveline::slaves::cia301
