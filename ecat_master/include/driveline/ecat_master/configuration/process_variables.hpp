#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/process_data/process_copy.hpp"

namespace driveline::ecat_master {

/// An entry of the process data with its names and its place.
struct ProcessVariable {
  std::string slave_name;      ///< as planned; its position where it has none
  std::uint16_t slave = 0;     ///< position on the line
  std::string name;            ///< out of the slave's description; may be empty
  std::string pdo_name;        ///< of the PDO it is mapped into; may be empty
  std::string alias;           ///< given by ProcessVariables::rename(); may be empty
  std::uint16_t index = 0;     ///< of the mapped object
  std::uint8_t subindex = 0;   ///< of the mapped object
  bool output = false;         ///< written by the master
  std::size_t bit_offset = 0;  ///< of ProcessImage::outputs() or inputs()
  unsigned bits = 0;           ///< length in the process data

  /// "x.6041h:00 (Status word)".
  [[nodiscard]] std::string text() const;
};

/// Why a name or handle of a process variable is refused, one type for each reason.
namespace variable_faults {

/// No variable has that name.
struct NotThere {
  std::string name;                      ///< name that was looked for
  std::vector<std::string> of_slave;     ///< variables of its slave; empty: there is no such slave
  std::optional<std::string> example{};  ///< an existing name; none: no process data are mapped
};
/// Several variables have that name.
struct Ambiguous {
  std::string name;                     ///< name that was looked for
  std::vector<std::string> candidates;  ///< the variables with that name
};
/// Another variable of the slave has that name already.
struct NameTaken {
  std::string alias;  ///< the new name
  std::string owner;  ///< the variable that has it
};
/// Size or place do not allow such a handle.
struct Unfit {
  ProcessVariable variable;     ///< that was found
  std::size_t wanted_bits = 0;  ///< of the handle
};
/// An output cannot be copied from.
struct NoSource {
  ProcessVariable variable;  ///< that was found
};
/// An input cannot be copied to.
struct NoTarget {
  ProcessVariable variable;  ///< that was found
};
/// Only variables of the same size are copied.
struct SizesDiffer {
  ProcessVariable from;  ///< that was found
  ProcessVariable to;    ///< that was found
};

}  // namespace variable_faults

/// Why a name or handle of a process variable is refused.
struct VariableError {
  /// The reason with its facts.
  std::variant<variable_faults::NotThere, variable_faults::Ambiguous, variable_faults::NameTaken,
               variable_faults::Unfit, variable_faults::NoSource, variable_faults::NoTarget,
               variable_faults::SizesDiffer>
      facts;
};

/// The error as one sentence, with the existing names where none or several match.
[[nodiscard]] std::string describe(const VariableError& error);

/// The process data of a line by their names, for programs and line descriptions. Made at start-up; its handles are for
/// the cycle. Not \rtsafe.
///
/// A variable is called `slave.object`: the name of the slave (or its position), then the name of the object as the
/// slave's description has it, with that of its PDO in front where several are called so ("io.Channel 1/Input"), or its
/// address as 0x6041, 6041h or 6041, with :subindex (hexadecimal) unless that is 0. In names letters may be upper or
/// lower case, and whatever is neither letter nor digit counts as one separator: "x.position_actual_value" is
/// "x.Position actual value".
class ProcessVariables {
 public:
  template <typename T>
  /// The result of a search, or why it failed.
  using Found = tl::expected<T, VariableError>;

  /// Collects the variables of configured slaves. Gaps in the mapping (index 0) are no variables.
  ProcessVariables(std::span<const ConfiguredSlave> slaves, const ProcessImage& image);

  /// In the order of slaves and of their process data, outputs first.
  [[nodiscard]] std::span<const ProcessVariable> all() const noexcept { return variables_; }
  /// Errors: NotThere, Ambiguous.
  [[nodiscard]] Found<ProcessVariable> find(std::string_view name) const;
  /// The name by which find() finds the variable: its alias, else its name, with its PDO in front when the slave has
  /// several of that name, else its address.
  [[nodiscard]] std::string full_name(const ProcessVariable& variable) const;
  /// Gives the variable `name` another name behind that of its slave, which takes precedence over its other names.
  /// Errors: those of find(), NameTaken.
  [[nodiscard]] Found<void> rename(std::string_view name, std::string_view alias);

  /// The handle of an entry of exactly this type's size; bool for a single bit. Errors: Unfit also when
  /// size or place do not allow a single load or store.
  template <typename T>
  [[nodiscard]] Found<PdoEntry<T>> entry(std::string_view name) const {
    auto variable = find(name);
    if (!variable) return tl::unexpected(variable.error());
    if constexpr (std::is_same_v<T, bool>) {
      if (variable->bits != 1) return unfit(*variable, 1);
      return PdoEntry<bool>(variable->bit_offset / 8, static_cast<unsigned>(variable->bit_offset % 8));
    } else {
      if (variable->bits != 8 * sizeof(T) || variable->bit_offset % 8 != 0) {
        return unfit(*variable, 8 * sizeof(T));
      }
      return PdoEntry<T>(variable->bit_offset / 8);
    }
  }
  /// The handle of an entry of up to 32 bits, wherever it lies.
  [[nodiscard]] Found<PdoBits> bits(std::string_view name) const;
  /// A copy of an input of one slave to an output of another in every cycle. Errors: also NoSource, NoTarget,
  /// SizesDiffer.
  [[nodiscard]] Found<ProcessDataCopy> copy(std::string_view from, std::string_view to) const;

 private:
  void add(const ConfiguredSlave& slave, const ProcessImage& image, bool output);
  [[nodiscard]] Found<std::size_t> find_number(std::string_view name) const;
  [[nodiscard]] static tl::unexpected<VariableError> unfit(ProcessVariable variable, std::size_t wanted_bits);

  std::vector<ProcessVariable> variables_;
};

}  // namespace driveline::ecat_master
