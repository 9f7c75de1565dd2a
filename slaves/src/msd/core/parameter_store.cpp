#include "driveline/slaves/msd/core/parameter_store.hpp"

namespace driveline::slaves::msd {

using std::chrono::nanoseconds;

ParameterStore::ParameterStore(const DictionaryTable& table, const MsdParameters& parameters, const ServoMotor& motor)
    : facts_(factory_facts(parameters)),
      motor_(&motor),
      stored_(table),
      file_(parameters.parameter_file),
      start_up_time_(parameters.start_up_time),
      factory_start_up_time_(parameters.factory_start_up_time),
      save_time_(parameters.save_time) {
  write_factory_settings(facts_, *motor_, stored_);
  if (!file_.empty()) load();
}

void ParameterStore::load() {
  const auto loaded = load_parameter_file(file_, stored_);
  if (!loaded) error_ = loaded.error();
  good_ = loaded.has_value();
}

bool ParameterStore::store(const ObjectDictionary& dictionary) {
  stored_are_factory_ = std::exchange(factory_reset_pending_, false);
  if (stored_are_factory_) {
    stored_.reset();
    write_factory_settings(facts_, *motor_, stored_);
  } else {
    stored_.copy_backup_values(dictionary);
  }
  save_left_ = save_time_;
  if (file_.empty()) return true;
  const auto saved = save_parameter_file(file_, stored_);
  if (!saved) error_ = saved.error();
  good_ = saved.has_value();
  return good_;
}

void ParameterStore::restore(ObjectDictionary& dictionary) {
  facts_.firmware = std::exchange(next_firmware_, std::nullopt).value_or(facts_.firmware);
  dictionary.reset();
  write_factory_settings(facts_, *motor_, dictionary);
  dictionary.copy_backup_values(stored_);
  factory_reset_pending_ = false;
  save_left_ = nanoseconds{0};
}

nanoseconds ParameterStore::take_start_up_time() noexcept {
  return std::exchange(stored_are_factory_, false) ? factory_start_up_time_ : start_up_time_;
}

}  // namespace driveline::slaves::msd
