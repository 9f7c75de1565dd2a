#pragma once

#include <map>
#include <string>
#include <string_view>

namespace driveline::bridge::clients {

/// A unit in which lengths are shown.
struct DisplayUnit {
  std::string_view name;  ///< "deg", "mm"
  bool linear = false;    ///< a length, not an angle
  double si = 1;          ///< rad or m per unit
};

/// Units of the axes of a line: samples are in rad and m, and do not say in which unit their line describes them.
class DisplayUnits {
 public:
  /// Adds "NAME=UNIT"; false: it has another form, or there is no such unit.
  [[nodiscard]] bool add(std::string_view text);
  /// Returns the unit of an axis; rad or m if none was added, or one of the other kind.
  [[nodiscard]] const DisplayUnit& of(const std::string& axis, bool linear) const;

 private:
  std::map<std::string, const DisplayUnit*> units_;
};

}  // namespace driveline::bridge::clients
