#include "master/placement.hpp"

#include <algorithm>
#include <compare>
#include <map>

namespace driveline::ecat_master {
namespace {

/// Place of a slave with a fixed position: a port of another slave with a fixed position.
struct Place {
  std::optional<std::size_t> on;  ///< empty: the master
  std::uint8_t port = 0;
  auto operator<=>(const Place&) const = default;
};

class Placer {
 public:
  explicit Placer(const LinePlaces& line)
      : line_(line),
        flat_(line.start.slaves.empty() || line.now.slaves.size() != line.known.size()),
        who_(line.known.begin(), line.known.end()),
        present_(line.roaming.size()) {
    for (const auto& slave : who_) {
      if (slave) present_[*slave] = true;
    }
    for (std::size_t slave = 0; slave < line.roaming.size(); ++slave) {
      if (!line.roaming[slave]) slaves_at_[place_at_start(slave)].push_back(slave);
    }
  }

  [[nodiscard]] std::vector<PlaceClaim> run() {
    for (auto groups = open_groups(); !groups.empty(); groups = open_groups()) {
      for (const auto& [place, positions] : groups) {
        for (const auto position : positions) settled_[position] = true;
        settle(place, positions);
      }
    }
    std::sort(claims_.begin(), claims_.end(), [](const auto& a, const auto& b) { return a.position < b.position; });
    return std::move(claims_);
  }

 private:
  using Groups = std::map<Place, std::vector<std::size_t>>;

  [[nodiscard]] Place place_at_start(std::size_t slave) const {
    if (flat_ || slave >= line_.start.slaves.size()) return {};
    auto parent = line_.start.slaves[slave].parent;
    while (parent && line_.roaming[parent->slave]) parent = line_.start.slaves[parent->slave].parent;
    return parent ? Place{parent->slave, parent->port} : Place{};
  }

  [[nodiscard]] bool roams(std::size_t position) const { return who_[position] && line_.roaming[*who_[position]]; }

  /// The place of a position; empty when it is behind an unidentified slave.
  [[nodiscard]] std::optional<Place> place_now(std::size_t position) const {
    if (flat_) return Place{};
    auto parent = line_.now.slaves[position].parent;
    while (parent && roams(parent->slave)) parent = line_.now.slaves[parent->slave].parent;
    if (!parent) return Place{};
    if (!who_[parent->slave]) return std::nullopt;
    return Place{*who_[parent->slave], parent->port};
  }

  /// Positions with a known place that have not been processed yet.
  [[nodiscard]] Groups open_groups() const {
    Groups groups;
    for (std::size_t position = 0; position < who_.size(); ++position) {
      if (settled_[position] || roams(position)) continue;
      if (const auto place = place_now(position)) groups[*place].push_back(position);
    }
    return groups;
  }

  /// Identified slaves divide the unidentified ones of a place into groups.
  void settle(const Place& place, std::span<const std::size_t> positions) {
    const auto found = slaves_at_.find(place);
    if (found == slaves_at_.end()) return;
    const std::span<const std::size_t> slaves(found->second);
    std::size_t next = 0;
    std::vector<std::size_t> newcomers;
    for (const auto position : positions) {
      if (!who_[position]) {
        newcomers.push_back(position);
        continue;
      }
      const auto here = std::find(slaves.begin() + static_cast<std::ptrdiff_t>(next), slaves.end(), *who_[position]);
      if (here == slaves.end()) continue;  // the slave has been moved
      const auto index = static_cast<std::size_t>(here - slaves.begin());
      claim(slaves.subspan(next, index - next), newcomers);
      next = index + 1;
      newcomers.clear();
    }
    claim(slaves.subspan(next), newcomers);
  }

  void claim(std::span<const std::size_t> slaves, std::span<const std::size_t> newcomers) {
    std::vector<std::size_t> missing;
    std::copy_if(slaves.begin(), slaves.end(), std::back_inserter(missing), [this](auto s) { return !present_[s]; });
    if (missing.empty()) return;
    const bool certain = missing.size() == newcomers.size();
    for (std::size_t i = 0; i < newcomers.size(); ++i) {
      const auto position = newcomers[i];
      claims_.push_back({static_cast<std::uint16_t>(position), certain ? std::vector{missing[i]} : missing, certain});
      if (!certain) continue;
      who_[position] = missing[i];
      present_[missing[i]] = true;
    }
  }

  const LinePlaces& line_;
  bool flat_;  ///< the wiring is unknown: everything is at one place
  std::vector<std::optional<std::size_t>> who_;
  std::vector<bool> present_;  ///< by slave
  std::map<Place, std::vector<std::size_t>> slaves_at_;
  std::vector<bool> settled_ = std::vector<bool>(who_.size());  ///< by position
  std::vector<PlaceClaim> claims_;
};

}  // namespace

std::vector<PlaceClaim> place_newcomers(const LinePlaces& line) {
  return Placer(line).run();
}

}  // namespace driveline::ecat_master
