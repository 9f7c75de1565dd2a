#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "master/placement.hpp"

namespace driveline::ecat_master {

/// A slave of the line: its station address and the alias that it loaded at power-on.
struct SeenSlave {
  std::uint16_t station = 0;
  std::uint16_t alias = 0;
  bool answers = false;
  std::optional<std::uint16_t> device_id{};  ///< read when a slave with a planned device ID is missing
};

/// Slaves that are on the running line without their station address: finds out which of the missing slaves each of
/// them is, and gives it that address back. Not real-time safe.
class Newcomers {
 public:
  using Readdressed = Master::Readdressed;  ///< a slave whose address was restored

  /// The line as configured; everything must outlive this object.
  struct Line {
    Bus& bus;                                    ///< reaches the slaves through the cycle
    const std::vector<ConfiguredSlave>& slaves;  ///< by number
    const std::vector<SlaveRef>& refs;           ///< their addresses
    const Topology& topology;                    ///< wiring at the start; empty: unknown
    const LineComparison& comparison;            ///< plans of the slaves
  };
  explicit Newcomers(const Line& line) : line_(line), unplaced_(line.slaves.size()), unproven_(line.slaves.size()) {}

  /// Restores addresses, see Master::readdress_newcomers().
  [[nodiscard]] Result<std::vector<Readdressed>> readdress();
  /// Why a slave that may have returned has no address; none: it has not returned, or has one.
  [[nodiscard]] const std::optional<Error>& unplaced(std::size_t slave) const noexcept { return unplaced_[slave]; }
  /// Whether the slave got its address by its position, and its identity has not been checked since.
  [[nodiscard]] bool unproven(std::size_t slave) const noexcept { return unproven_[slave]; }
  /// The identity of the slave has been checked.
  void prove(std::size_t slave) noexcept { unproven_[slave] = false; }

 private:
  /// The line as it is now.
  struct Survey {
    std::vector<SeenSlave> seen;                    ///< by position
    std::vector<std::optional<std::size_t>> known;  ///< number of the slave by position; empty: not identified
    std::vector<bool> present;                      ///< by slave: it is identified at a position
    std::size_t reached = 0;                        ///< positions up to the last slave that answers
    std::vector<Readdressed> moved;                 ///< slaves that got their address back
  };
  /// Position on the line and number of the slave.
  using Place = std::pair<std::size_t, std::size_t>;

  [[nodiscard]] Result<Survey> survey();
  [[nodiscard]] Result<void> read_ids(Survey& line);
  [[nodiscard]] std::vector<Place> find_roaming(const Survey& line) const;
  [[nodiscard]] std::vector<Place> find_behind_heads(const Survey& line) const;
  [[nodiscard]] Result<std::vector<Place>> find_by_wiring(const Survey& line);
  [[nodiscard]] Result<void> settle_claims(std::span<const PlaceClaim> claims, std::vector<Place>& placed);
  [[nodiscard]] Result<void> place_by_serial(std::span<const PlaceClaim> doubtful, std::vector<Place>& placed);
  void explain_unplaced(std::span<const PlaceClaim> doubtful, std::span<const Place> placed);
  [[nodiscard]] Result<void> give_addresses(std::span<const Place> places, Survey& line);
  [[nodiscard]] Result<std::vector<SlaveRef>> assign_temporary_addresses(std::span<const std::uint16_t> positions);
  [[nodiscard]] bool is_missing_roamer(const Survey& line, std::size_t slave) const;

  Line line_;
  std::vector<std::optional<Error>> unplaced_;
  std::vector<bool> unproven_;
};

}  // namespace driveline::ecat_master
