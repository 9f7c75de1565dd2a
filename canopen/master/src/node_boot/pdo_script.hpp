#pragma once

#include "boot_script.hpp"

namespace driveline::canopen {

/// Writes the steps that bring the PDOs of a node to what the plan wants. A PDO that is so already is only read;
/// another one is switched off, changed, and switched on, in the order of CiA 301 7.5.2.36. PDOs 1 to 4 that the plan
/// does not have are switched off, because the budget of the bus does not count them.
class PdoScript {
 public:
  explicit PdoScript(const BootScript& script) noexcept : script_(script) {}
  /// All PDOs of the plan.
  void configure() const;

 private:
  /// A PDO of the plan.
  struct Place {
    bool rpdo = false;
    std::size_t number = 0;  ///< in its list of the plan
  };
  /// What the node has.
  struct Found {
    CobId cob{};
    std::uint32_t transmission = 0;
    std::optional<std::uint32_t> inhibit_100us{};
    std::optional<std::uint32_t> event_ms{};
    std::vector<motion::MappedObject> objects{};
  };
  using Shared = std::shared_ptr<Found>;

  [[nodiscard]] PdoPlan& plan(Place place) const;
  [[nodiscard]] KnownEntry communication(Place place, std::uint8_t subindex, std::size_t bytes) const;
  [[nodiscard]] KnownEntry mapping(Place place, std::uint8_t subindex) const;
  [[nodiscard]] NodeError error(Place place, NodeErrorKind kind, SdoObject object) const;
  void read(Place place) const;
  void read_mapping(Place place, const Shared& found, std::function<void()> then) const;
  void decide(Place place, const Found& found) const;
  [[nodiscard]] bool adopt(Place place, const Found& found) const;
  void change(Place place, const Found& found) const;
  void map(Place place, const Found& found) const;
  void verify(Place place) const;
  void set_time(Place place, std::uint8_t subindex, std::optional<std::uint16_t> wanted,
                std::optional<std::uint32_t> found) const;
  void switch_off_others(bool rpdo) const;

  BootScript script_;
};

}  // namespace driveline::canopen
