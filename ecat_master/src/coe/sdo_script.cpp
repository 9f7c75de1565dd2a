#include "driveline/ecat_master/coe/sdo_script.hpp"

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>

namespace driveline::ecat_master {
namespace {

using SdoValue = std::vector<std::byte>;

/// The number in up to four bytes; empty: more bytes, or none.
std::optional<std::uint32_t> small_number(const SdoValue& data) {
  if (data.empty() || data.size() > sizeof(std::uint32_t)) return std::nullopt;
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < data.size(); ++i) number |= std::to_integer<std::uint32_t>(data[i]) << (8 * i);
  return number;
}

/// The script of one slave: one transfer at a time.
class ScriptRun {
 public:
  ScriptRun(MailboxEngine& engine, const SdoScript& script, StartupNotes& notes)
      : engine_(engine), script_(script), notes_(notes) {
    start_step();
  }

  [[nodiscard]] bool open() const noexcept { return transfer_ != nullptr; }
  [[nodiscard]] const Result<void>& result() const noexcept { return result_; }

  /// Takes the result of the present transfer and starts the next one. Returns false when it is still in progress.
  bool advance() {
    if (!transfer_->done()) return false;
    const auto transfer = std::move(transfer_);
    transfer_.reset();
    const auto& answer = transfer->result();
    if (!answer && !answer.error().is<facts::SdoAbort>()) {
      result_ = tl::unexpected(answer.error());
      return true;
    }
    switch (phase_) {
      case Phase::kRead:
        take_present(answer);
        break;
      case Phase::kWrite:
        take_written(answer);
        break;
      case Phase::kReadBack:
        take_read_back(answer);
        break;
      case Phase::kRestore:
        restore_next();
        break;
    }
    return true;
  }

 private:
  enum class Phase : std::uint8_t {
    kRead,      ///< reads the present value
    kWrite,     ///< writes
    kReadBack,  ///< reads the value that was written
    kRestore,   ///< gives an entry of a refused object its value of before
  };
  /// An entry that was written, with its value of before.
  struct Changed {
    SdoAddress at;
    SdoValue before;
  };

  [[nodiscard]] const SdoScript::Step& step() const { return script_.steps[next_]; }
  [[nodiscard]] bool optional() const { return step().need == motion::WriteNeed::kOptional; }
  [[nodiscard]] facts::ObjectAddress object() const { return {step().at.index, step().at.subindex}; }

  void upload(Phase phase) { submit(phase, std::make_shared<SdoTransfer>(step().at)); }
  void download() { submit(Phase::kWrite, std::make_shared<SdoTransfer>(step().at, step().data)); }
  void submit(Phase phase, std::shared_ptr<SdoTransfer> transfer) {
    phase_ = phase;
    transfer_ = std::move(transfer);
    engine_.submit(script_.position, transfer_);
  }

  [[nodiscard]] bool left_out() const {
    return step().need == motion::WriteNeed::kOmitted ||
           std::find(refused_.begin(), refused_.end(), step().at.index) != refused_.end();
  }
  /// Starts the next step that is not left out; without one the script is over.
  void start_step() {
    while (next_ < script_.steps.size() && left_out()) ++next_;
    present_.reset();
    if (next_ == script_.steps.size()) return;
    if (step().compared) {
      upload(Phase::kRead);
    } else {
      download();
    }
  }
  void finish_step() {
    ++next_;
    start_step();
  }

  void take_present(const Result<SdoValue>& answer) {
    // An entry that cannot be read may still be writable.
    if (answer) present_ = *answer;
    if (answer && *answer == step().data) return finish_step();
    download();
  }

  void take_written(const Result<SdoValue>& answer) {
    if (!answer) return take_refusal(answer.error());
    if (step().compared && present_) changed_.push_back({step().at, *present_});
    if (!step().compared) return finish_step();
    upload(Phase::kReadBack);
  }

  void take_refusal(const Error& error) {
    if (!optional()) {
      result_ = tl::unexpected(error);
      return;
    }
    notes::WriteRefused refused{object(), error.as<facts::SdoAbort>()->code, small_number(step().data), {}};
    if (present_) refused.present = small_number(*present_);
    notes_.push_back({script_.position, refused});
    leave_object();
  }

  void take_read_back(const Result<SdoValue>& answer) {
    const auto wanted = small_number(step().data);
    const auto found = answer ? small_number(*answer) : std::nullopt;
    // An entry that cannot be read back has accepted its value.
    if (!wanted || !found || *wanted == *found) return finish_step();
    if (!optional()) {
      result_ = tl::unexpected(
          Error{facts::SyncObject{.object = object(), .written = *wanted, .read = *found}, script_.position});
      return;
    }
    notes_.push_back({script_.position, notes::WriteIgnored{object(), *wanted, *found}});
    leave_object();
  }

  /// Leaves out the rest of the object: its entries belong together, like value and exponent of 60C2h.
  void leave_object() {
    refused_.push_back(step().at.index);
    restore_next();
  }

  /// Restores the entries of the refused object, the last one first.
  void restore_next() {
    const auto entry = std::find_if(changed_.rbegin(), changed_.rend(),
                                    [this](const Changed& changed) { return changed.at.index == refused_.back(); });
    if (entry == changed_.rend()) return finish_step();
    auto transfer = std::make_shared<SdoTransfer>(entry->at, std::move(entry->before));
    changed_.erase(std::next(entry).base());
    submit(Phase::kRestore, std::move(transfer));
  }

  MailboxEngine& engine_;
  const SdoScript& script_;
  StartupNotes& notes_;
  std::size_t next_ = 0;
  Phase phase_ = Phase::kRead;
  std::shared_ptr<SdoTransfer> transfer_;
  std::optional<SdoValue> present_;
  std::vector<Changed> changed_;
  std::vector<std::uint16_t> refused_;  ///< objects whose further steps are left out
  Result<void> result_;
};

}  // namespace

std::vector<Result<void>> run_scripts(MailboxEngine& engine, std::span<const SdoScript> scripts, StartupNotes* notes) {
  StartupNotes unread;
  std::vector<ScriptRun> runs;
  runs.reserve(scripts.size());
  for (const auto& script : scripts) runs.emplace_back(engine, script, notes != nullptr ? *notes : unread);
  for (bool open = true; open;) {
    open = false;
    bool moved = false;
    for (auto& run : runs) {
      if (!run.open()) continue;
      open = true;
      moved = run.advance() || moved;
    }
    if (open && !moved) engine.drive();
  }
  std::vector<Result<void>> results;
  for (const auto& run : runs) results.push_back(run.result());
  return results;
}

}  // namespace driveline::ecat_master
