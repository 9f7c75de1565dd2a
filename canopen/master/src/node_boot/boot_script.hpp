#pragma once

#include <functional>

#include "driveline/canopen_master/node_boot.hpp"

namespace driveline::canopen {

/// An entry of the dictionary of CiA 301 with its length.
struct KnownEntry {
  SdoObject object;
  std::size_t bytes = 4;
};

/// Writes the steps of the boot of a node into its SdoScript.
class BootScript {
 public:
  explicit BootScript(NodeBoot& boot) noexcept : boot_(&boot) {}

  /// Everything up to the PDOs.
  void configure() const;
  /// The heartbeat in both directions.
  void heartbeat() const;
  /// Node guarding.
  void guarding() const;
  /// The watch of the node over the master off.
  void release() const;

  /// \name Tools of the steps
  /// @{

  /// Reads a number; what cannot be read is empty, and the node is there.
  void read(KnownEntry entry, std::function<void(std::optional<std::uint32_t>)> then) const;
  /// Reads a number that the node must have.
  void demand(KnownEntry entry, std::function<void(std::uint32_t)> then) const;
  /// Writes a number. `refused` decides what a refusal means; empty: it ends the boot.
  void write(KnownEntry entry, std::uint32_t value, std::uint32_t found,
             std::function<void(const NodeError&)> refused = {}) const;
  /// Writes a number where the node has another one. kOptional: a refusal is noted.
  void compare(KnownEntry entry, std::uint32_t wanted, motion::WriteNeed need) const;
  void call(std::function<void()> function) const { boot_->sdo_.call(std::move(function)); }
  [[nodiscard]] NodeError error(NodeErrorKind kind, SdoObject object = {}) const {
    return boot_->error_of(kind, object);
  }
  void fail(const NodeError& error) const { boot_->fail(error); }
  void note(const NodeError& error) const { boot_->notes_.push_back(error); }
  [[nodiscard]] NodePlan& plan() const noexcept { return boot_->plan_; }
  /// @}

 private:
  using Consumers = std::vector<std::uint32_t>;

  void step(BootStep step, std::function<void()> function) const;
  void device_type() const;
  void identity() const;
  void identify(std::uint8_t subindex, std::optional<std::uint32_t> wanted,
                std::optional<std::uint32_t> NodeIdentity::*found) const;
  void quiet() const;
  void switch_off(KnownEntry entry) const;
  void startup_sdos() const;
  void compare(const motion::StartupSdo& sdo) const;
  void write(const motion::StartupSdo& sdo, std::uint32_t found) const;
  void sync() const;
  void read_consumers(std::uint8_t subindex, std::size_t count, const std::shared_ptr<Consumers>& values,
                      const std::function<void(const Consumers&)>& then) const;
  void with_consumers(std::function<void(const Consumers&)> then, bool needed) const;
  void watch_master(const Consumers& consumers) const;
  void forget_master(const Consumers& consumers) const;

  NodeBoot* boot_;
};

}  // namespace driveline::canopen
