#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/generic/device_model.hpp"
#include "driveline/slaves/generic/ideal_drives.hpp"
#include "driveline/slaves/generic/soe_drives.hpp"
#include "driveline/slaves/mailbox/coe_server.hpp"
#include "driveline/slaves/mailbox/eoe_server.hpp"
#include "driveline/slaves/mailbox/soe_server.hpp"
#include "driveline/slaves/signal.hpp"

namespace driveline::slaves::generic {

/// An input whose value follows a script.
struct ScriptedInput {
  const EntryRow* input = nullptr;  ///< row in the model's table, from DeviceModel::find_input()
  Signal signal;                    ///< in the unit of the entry; starts with the first advance()
};

/// Checks whether the input accepts all values of the signal.
[[nodiscard]] tl::expected<void, SignalValueError> check_signal(const EntryRow& input, const Signal& signal);

/// AL status code of a refused transition when drives have found invalid operation data: one of the vendor's, because
/// ETG.1020 has none for it.
inline constexpr auto kSoeCheckFailed = static_cast<wire::AlStatusCode>(0x8127);

/// Options of an individual device.
struct GenericOptions {
  std::uint32_t serial_number = 0;     ///< 0: serial number of the description
  std::vector<std::byte> sii_image{};  ///< EEPROM content; empty: made from the description
  /// The controller has a clock, like the ET1100 class even in devices without DC modes; it measures the frame path.
  bool distributed_clock = true;
  bool loop_back = true;                ///< inputs repeat outputs
  std::vector<ScriptedInput> inputs{};  ///< inputs that follow a script; the others repeat outputs or stay 0
  /// Checks of the drives of a device with SoE in the transitions to SAFEOP and OP. A violated one is refused with AL
  /// status code kSoeCheckFailed.
  std::vector<SoeRule> soe_rules{};
};

/// A device simulated from its description (an ESI file or an EEPROM image): identity, sync managers, process data,
/// object dictionary, CoE, EoE and SoE. Its application is minimal: drives of CiA 402 are ideal ones (IdealDrives), and
/// other inputs repeat outputs or follow a script.
///
/// With loop-back, each input entry repeats the next output entry of the same length, both in the order of the process
/// data. Outputs are set to 0 when OP is left. A device without mailbox and with a PDI that has no application is run
/// by its controller alone (device emulation).
///
/// Belongs to the thread that drives the line. Times are relative to the first call of advance().
class GenericDevice final : public Device, public DeviceSignals, private DictionaryOwner {
 public:
  /// Precondition: every input of `options` belongs to the model.
  GenericDevice(std::shared_ptr<const DeviceModel> model, const GenericOptions& options);
  GenericDevice(const GenericDevice&) = delete;  // the CoE server refers to the dictionary of this object
  GenericDevice& operator=(const GenericDevice&) = delete;
  ~GenericDevice() override = default;

  // Device
  /// Returns the profile with the EEPROM image of the options, or with an image made from the description.
  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override;
  [[nodiscard]] std::optional<MappedEntry> mapped_input(std::uint16_t index,
                                                        std::uint8_t subindex) const noexcept override;
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override;
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override;
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override;
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override;
  [[nodiscard]] bool takes_mailbox(std::span<const std::byte> mailbox) const noexcept override {
    return mailbox_.has_room(mailbox);
  }
  void mailbox_request(std::span<const std::byte> mailbox) override;
  bool connect_network(EthernetLink* network) override;
  /// Shows the identity and the entries of the PDOs.
  void show(DeviceStatus& out) const noexcept override;
  void restart() override;
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte> out) override { return mailbox_.reply(out, al_state_); }
  /// Shows the SYNC0 cycle in sub-index 02 of 1C32h and the like; without SYNC0 the value of the master stays.
  void sync_started(std::chrono::nanoseconds sync0_cycle) noexcept override;
  void advance(std::chrono::nanoseconds now) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds process_data_period() const noexcept override;
  [[nodiscard]] DeviceSignals* signals() noexcept override { return this; }

  // DeviceSignals: the PDO entries that are numbers or texts; texts cannot be set and read as 0.
  /// Returns the number of entries of TxPDOs (inputs) or RxPDOs (outputs).
  [[nodiscard]] std::size_t signal_count(Direction direction) const noexcept override { return rows(direction).size(); }
  /// Returns the name of PDO and entry, as DeviceModel::find_input() accepts it.
  [[nodiscard]] std::string signal_name(SignalId id) const override;
  [[nodiscard]] tl::expected<SignalId, SignalNameError> find_signal(Direction direction,
                                                                    std::string_view name) const override;
  [[nodiscard]] tl::expected<void, SignalValueError> check_signal_value(std::size_t input, double value) const override;
  void set_signal(std::size_t input, double value) noexcept override;
  [[nodiscard]] double signal(SignalId id) const noexcept override;

  /// Returns the model that all devices of the type share.
  [[nodiscard]] const DeviceModel& model() const noexcept { return *model_; }
  /// Returns the current values.
  [[nodiscard]] const ObjectDictionary& dictionary() const noexcept { return dictionary_; }
  /// Returns the mailbox server, for its counters.
  [[nodiscard]] const MailboxServer& mailbox() const noexcept { return mailbox_; }

 private:
  struct Loop {
    PdoMap::Field output;
    PdoMap::Field input;
  };

  // DictionaryOwner
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  [[nodiscard]] bool power_stage_on() const noexcept override { return false; }

  void build_process_data();
  void build_loops();
  [[nodiscard]] bool driven(const PdoMap::Field& field) const noexcept;
  [[nodiscard]] const std::vector<DeviceModel::NamedEntry>& rows(Direction direction) const noexcept {
    return direction == Direction::kInput ? inputs_ : outputs_;
  }
  void enter_al_state(wire::AlState state) noexcept;
  void clear_outputs() noexcept;
  void loop_back() noexcept;
  [[nodiscard]] wire::AlStatusCode check_assignments() const noexcept;

  std::shared_ptr<const DeviceModel> model_;
  DeviceProfile profile_;
  ObjectDictionary dictionary_;
  CoeServer coe_;
  std::uint32_t serial_number_;
  std::unique_ptr<EoeServer> eoe_;         ///< null: the device has no EoE
  std::unique_ptr<SoeDrives> soe_drives_;  ///< null: the device has no SoE
  std::unique_ptr<SoeServer> soe_;         ///< SoE server of soe_drives_; null: none
  IdealDrives drives_;                     ///< those of CiA 402
  bool mapped_by_idn_;                     ///< soe_drives_ defines the process data
  MailboxServer mailbox_;
  std::vector<PdoMap> maps_;  ///< by sync manager
  bool looped_;
  std::vector<Loop> loops_;
  std::vector<ScriptedInput> scripts_;
  std::vector<DeviceModel::NamedEntry> inputs_;
  std::vector<DeviceModel::NamedEntry> outputs_;
  std::vector<std::uint16_t> set_slots_;  ///< slots of the inputs set by set_signal(); memory is reserved for all
  wire::AlState al_state_ = wire::AlState::kInit;
  std::optional<std::chrono::nanoseconds> start_;
  std::chrono::nanoseconds now_{0};
};

}  // namespace driveline::slaves::generic
