#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/cia301/process_copy.hpp"

namespace driveline::ecat_master {

/// An entry of the process data with its names and position.
struct ProcessVariable {
  std::string slave_name;      ///< planned name of the slave; its position if it has none
  std::uint16_t slave = 0;     ///< position on the line
  std::string name;            ///< name from the slave's description; may be empty
  std::string pdo_name;        ///< name of the PDO that contains the entry; may be empty
  std::string alias;           ///< given by ProcessVariables::rename(); may be empty
  std::uint16_t index = 0;     ///< index of the mapped object
  std::uint8_t subindex = 0;   ///< sub-index of the mapped object
  bool output = false;         ///< written by the master
  std::size_t bit_offset = 0;  ///< offset in the image of outputs or inputs
  unsigned bits = 0;           ///< length in the process data

  /// "x.6041h:00 (Status word)".
  [[nodiscard]] std::string text() const;
};

/// Why a name or handle of a process variable is refused: one type per reason.
namespace variable_faults {

/// No variable has the name.
struct NotThere {
  std::string name;                      ///< the name searched for
  std::vector<std::string> of_slave;     ///< variables of the slave; empty: there is no such slave
  std::optional<std::string> example{};  ///< an existing name; none: no process data are mapped
};
/// Several variables have the name.
struct Ambiguous {
  std::string name;                     ///< the name searched for
  std::vector<std::string> candidates;  ///< the variables with that name
};
/// Another variable of the slave already has the name.
struct NameTaken {
  std::string alias;  ///< the new name
  std::string owner;  ///< the variable that has it
};
/// Size or position of the variable do not allow the handle.
struct Unfit {
  ProcessVariable variable;     ///< the variable found
  std::size_t wanted_bits = 0;  ///< size of the handle
};
/// An output cannot be the source of a copy.
struct NoSource {
  ProcessVariable variable;  ///< the variable found
};
/// An input cannot be the target of a copy.
struct NoTarget {
  ProcessVariable variable;  ///< the variable found
};
/// Source and target of a copy differ in size.
struct SizesDiffer {
  ProcessVariable from;  ///< the source found
  ProcessVariable to;    ///< the target found
};

}  // namespace variable_faults

/// Why a name or handle of a process variable is refused.
struct VariableError {
  /// The reason with its details.
  std::variant<variable_faults::NotThere, variable_faults::Ambiguous, variable_faults::NameTaken,
               variable_faults::Unfit, variable_faults::NoSource, variable_faults::NoTarget,
               variable_faults::SizesDiffer>
      facts;
};

/// The error as one sentence, listing existing names when no variable or several variables match.
[[nodiscard]] std::string describe(const VariableError& error);

/// The process data of a line by name, for programs and line descriptions. Created at start-up; the cycle uses its
/// handles. Not \rtsafe.
///
/// A variable is named `slave.object`: the name of the slave (or its position), then either the name of the object from
/// the slave's description, preceded by the name of its PDO if several have this name ("io.Channel 1/Input"), or its
/// address as 0x6041, 6041h or 6041, with :subindex (hexadecimal) unless that is 0. Names are not case-sensitive, and
/// any characters other than letters and digits count as one separator: "x.position_actual_value" is "x.Position actual
/// value".
class ProcessVariables {
 public:
  template <typename T>
  /// The result of a search, or why it failed.
  using Found = tl::expected<T, VariableError>;

  /// Collects the variables of configured slaves. Gaps in the mapping (index 0) are not variables.
  ProcessVariables(std::span<const ConfiguredSlave> slaves, const ProcessImage& image);
  /// Takes variables that another bus has placed in its image.
  explicit ProcessVariables(std::vector<ProcessVariable> variables) : variables_(std::move(variables)) {}

  /// All variables in the order of slaves and of their process data, outputs first.
  [[nodiscard]] std::span<const ProcessVariable> all() const noexcept { return variables_; }
  /// Errors: NotThere, Ambiguous.
  [[nodiscard]] Found<ProcessVariable> find(std::string_view name) const;
  /// The name by which find() finds the variable: its alias, else its name, preceded by its PDO when the slave has
  /// several variables of that name, else its address.
  [[nodiscard]] std::string full_name(const ProcessVariable& variable) const;
  /// Gives the variable `name` an alias behind the name of its slave; the alias takes precedence over its other names.
  /// Errors: those of find(), NameTaken.
  [[nodiscard]] Found<void> rename(std::string_view name, std::string_view alias);

  /// A handle for an entry of exactly this type's size; bool for a single bit. Errors: those of find(); Unfit when size
  /// or position do not allow a single load or store.
  template <typename T>
  [[nodiscard]] Found<motion::PdoEntry<T>> entry(std::string_view name) const {
    auto variable = find(name);
    if (!variable) return tl::unexpected(variable.error());
    if constexpr (std::is_same_v<T, bool>) {
      if (variable->bits != 1) return unfit(*variable, 1);
      return motion::PdoEntry<bool>(variable->bit_offset / 8, static_cast<unsigned>(variable->bit_offset % 8));
    } else {
      if (variable->bits != 8 * sizeof(T) || variable->bit_offset % 8 != 0) {
        return unfit(*variable, 8 * sizeof(T));
      }
      return motion::PdoEntry<T>(variable->bit_offset / 8);
    }
  }
  /// A handle for an entry of up to 32 bits, at any bit position.
  [[nodiscard]] Found<motion::PdoBits> bits(std::string_view name) const;
  /// A copy of an input of a slave to an output of another slave in every cycle. Errors: also NoSource, NoTarget,
  /// SizesDiffer.
  [[nodiscard]] Found<motion::ProcessDataCopy> copy(std::string_view from, std::string_view to) const;

 private:
  void add(const ConfiguredSlave& slave, const ProcessImage& image, bool output);
  [[nodiscard]] Found<std::size_t> find_number(std::string_view name) const;
  [[nodiscard]] static tl::unexpected<VariableError> unfit(ProcessVariable variable, std::size_t wanted_bits);

  std::vector<ProcessVariable> variables_;
};

}  // namespace driveline::ecat_master
