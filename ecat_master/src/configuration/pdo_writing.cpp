#include "configuration/pdo_writing.hpp"

#include <algorithm>

#include "configuration/assigned_pdos.hpp"
#include "driveline/ecat_master/configuration/pdo_discovery.hpp"

namespace driveline::ecat_master {
namespace {

/// Assignment objects of the sync managers 0 to 31 (ETG.1000.6 Table 67).
constexpr std::uint16_t kLastAssignment = 0x1C2F;

/// The plan of a sync manager of a slave, and whether the slave takes it.
struct Wanted {
  ConfiguredSlave* slave = nullptr;
  AssignmentPlan plan{};
  bool present = false;         ///< the slave has these PDOs already
  bool unwritten = false;       ///< some of the plan was refused, or is not to be written
  bool own_assignment = false;  ///< this includes the assignment
};

bool is_assignment(std::uint16_t index) {
  return index >= kPdoAssignment && index <= kLastAssignment;
}

motion::WriteNeed need_of(const StartupNeeds& needs, std::uint16_t index) {
  return is_assignment(index) ? needs.pdo_assignment : needs.pdo_mapping;
}

/// A slave with fixed PDOs refuses the first write to the object, which clears it. A slave that accepts this and
/// refuses a later write can be configured, but not as planned, which is always an error.
void apply_needs(const StartupNeeds& needs, std::vector<SdoScript::Step>& steps) {
  for (auto& step : steps) {
    const auto need = need_of(needs, step.at.index);
    const bool clears = step.at.subindex == 0 && step.data == std::vector{std::byte{0}};
    if (need == motion::WriteNeed::kOmitted || (need == motion::WriteNeed::kOptional && clears)) step.need = need;
  }
}

class PdoWriting {
 public:
  PdoWriting(MailboxEngine& engine, StartupNotes& notes) : engine_(engine), notes_(notes) {}

  Result<void> run(std::span<ConfiguredSlave> slaves) {
    for (auto& slave : slaves) {
      if (auto done = add(slave); !done) return done;
    }
    if (auto done = compare(); !done) return done;
    if (auto done = write(); !done) return done;
    return keep_own();
  }

 private:
  Result<void> add(ConfiguredSlave& slave) {
    if (!slave.present) return {};
    const bool has_coe = slave.mailbox && slave.info.description.mailbox.coe;
    for (auto& plan : planned_assignments(slave)) {
      if (!has_coe && !plan.steps.empty())
        return tl::unexpected(Error{facts::NoMailbox{wire::MailboxType::kCoe}, slave.info.ref.position});
      apply_needs(slave.plan.needs, plan.steps);
      wanted_.push_back({&slave, std::move(plan)});
    }
    return {};
  }

  /// Finds the plans that need no writing. An assignment that cannot be read is written.
  Result<void> compare() {
    std::vector<SlaveInfo> infos;
    std::vector<SyncManagerPlace> places;
    for (const auto& wanted : wanted_) {
      if (infos.empty() || infos.back().ref.position != wanted.slave->info.ref.position)
        infos.push_back(wanted.slave->info);
      places.push_back({infos.size() - 1, wanted.plan.sync_manager});
    }
    StartupNotes not_of_interest;
    const auto read = read_assignments(engine_, infos, places, not_of_interest);
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      auto& wanted = wanted_[i];
      if (!read[i] && !is_answer(read[i].error())) return tl::unexpected(read[i].error());
      wanted.present = read[i] ? motion::same_pdos(wanted.plan.pdos, *read[i]) : has_none(wanted.plan, read[i].error());
    }
    return {};
  }

  /// Whether the slave answers, but does not show its assignment.
  static bool is_answer(const Error& error) { return error.is<facts::SdoAbort>() || error.is<facts::SdoSize>(); }

  /// Nothing is to be assigned to a sync manager whose assignment does not exist.
  static bool has_none(const AssignmentPlan& plan, const Error& error) {
    const auto* abort = error.as<facts::SdoAbort>();
    return plan.pdos.empty() && abort != nullptr && abort->code == wire::SdoAbort::kObjectDoesNotExist;
  }

  Result<void> write() {
    std::vector<SdoScript> scripts;
    for (auto& wanted : wanted_) {
      if (wanted.present) continue;
      for (const auto& step : wanted.plan.steps) {
        if (step.need == motion::WriteNeed::kOmitted) mark_unwritten(wanted, step.at.index);
      }
      const auto position = wanted.slave->info.ref.position;
      if (scripts.empty() || scripts.back().position != position) scripts.push_back({position, {}});
      auto& steps = scripts.back().steps;
      steps.insert(steps.end(), wanted.plan.steps.begin(), wanted.plan.steps.end());
    }
    StartupNotes refused;
    const auto results = run_scripts(engine_, scripts, &refused);
    for (const auto& note : refused) mark_refused(note);
    notes_.insert(notes_.end(), refused.begin(), refused.end());
    return first_failure(results);
  }

  static void mark_unwritten(Wanted& wanted, std::uint16_t index) {
    wanted.unwritten = true;
    if (is_assignment(index)) wanted.own_assignment = true;
  }

  /// Marks the plan one of whose writes was refused.
  void mark_refused(const StartupNote& note) {
    const auto* refused = note.as<notes::WriteRefused>();
    if (refused == nullptr) return;
    for (auto& wanted : wanted_) {
      const auto& steps = wanted.plan.steps;
      const bool mine = wanted.slave->info.ref.position == note.slave &&
                        std::any_of(steps.begin(), steps.end(), [&](const SdoScript::Step& step) {
                          return step.at.index == refused->object.index;
                        });
      if (mine) mark_unwritten(wanted, refused->object.index);
    }
  }

  /// Takes over the PDOs of slaves that do not have all of what was planned.
  Result<void> keep_own() {
    std::vector<SlaveInfo> infos;
    std::vector<ConfiguredSlave*> owners;
    for (const auto& wanted : wanted_) {
      if (!wanted.unwritten || (!owners.empty() && owners.back() == wanted.slave)) continue;
      infos.push_back(wanted.slave->info);
      owners.push_back(wanted.slave);
    }
    auto own = read_pdo_configurations(engine_, infos, notes_);
    for (std::size_t i = 0; i < owners.size(); ++i) {
      if (!own[i]) return tl::unexpected(own[i].error());
      for (const auto& wanted : wanted_) {
        if (wanted.unwritten && wanted.slave == owners[i]) replace(wanted, *own[i]);
      }
    }
    return {};
  }

  void replace(const Wanted& wanted, const motion::PdoConfiguration& own) {
    auto& plan = wanted.slave->plan;
    const bool outputs = wanted.plan.outputs;
    auto& planned = outputs ? plan.pdos.outputs : plan.pdos.inputs;
    const auto& present = outputs ? own.outputs : own.inputs;
    if (motion::same_pdos(planned, present)) return;
    planned = present;
    for (auto& pdo : planned) pdo.own_mapping = true;
    if (wanted.own_assignment) (outputs ? plan.kept.outputs : plan.kept.inputs) = true;
    notes_.push_back({wanted.slave->info.ref.position,
                      notes::PlannedPdosReplaced{outputs, static_cast<std::uint16_t>(present.size()),
                                                 static_cast<std::uint16_t>(motion::bytes_of(present))}});
  }

  MailboxEngine& engine_;
  StartupNotes& notes_;
  std::vector<Wanted> wanted_;
};

}  // namespace

Result<void> write_planned_pdos(MailboxEngine& engine, std::span<ConfiguredSlave> slaves, StartupNotes& notes) {
  return PdoWriting(engine, notes).run(slaves);
}

}  // namespace driveline::ecat_master
