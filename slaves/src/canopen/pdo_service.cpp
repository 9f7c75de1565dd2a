#include "driveline/slaves/canopen/pdo_service.hpp"

namespace driveline::slaves::cia301 {

PdoService::PdoService(ObjectDictionary& dictionary, Application& application, EmergencyService& emergency,
                       const DeviceOptions& options, Outbox& outbox)
    : dictionary_(&dictionary), application_(&application), emergency_(&emergency), options_(&options) {
  rpdos_.reserve(options.rpdos);
  tpdos_.reserve(options.tpdos);
  for (std::size_t i = 0; i < options.rpdos; ++i) rpdos_.emplace_back(dictionary, application, i, options);
  for (std::size_t i = 0; i < options.tpdos; ++i) tpdos_.emplace_back(dictionary, i, options, outbox);
  rpdos_in_use_.reserve(options.rpdos);
  tpdos_with_sync_.reserve(options.tpdos);
  tpdos_with_events_.reserve(options.tpdos);
}

void PdoService::start(nanoseconds now) noexcept {
  running_ = true;
  for (Rpdo& rpdo : rpdos_) rpdo.restart();
  for (Tpdo& tpdo : tpdos_) tpdo.start(now);
  select();
}

void PdoService::select() noexcept {
  rpdos_in_use_.clear();
  for (std::size_t i = 0; i < rpdos_.size(); ++i) {
    if (rpdos_[i].active()) rpdos_in_use_.push_back({rpdos_[i].identifier(), static_cast<std::uint16_t>(i)});
  }
  const auto choose = [this](Places& places, auto&& wanted) {
    places.clear();
    for (std::size_t i = 0; i < tpdos_.size(); ++i) {
      if (wanted(tpdos_[i])) places.push_back(static_cast<std::uint16_t>(i));
    }
  };
  choose(tpdos_with_sync_, [](const Tpdo& tpdo) { return tpdo.waits_for_sync(); });
  choose(tpdos_with_events_, [](const Tpdo& tpdo) { return tpdo.waits_for_events(); });
}

void PdoService::stop() noexcept {
  running_ = false;
  cycle_ = kNever;
  for (Tpdo& tpdo : tpdos_) tpdo.stop();
}

SdoResult<void> PdoService::check(const EntryRow& row, std::uint64_t raw) const {
  auto result = check_pdo_write(*dictionary_, options_->mapping, row, raw);
  for (const Rpdo& rpdo : rpdos_) {
    if (result) result = rpdo.check(row, static_cast<std::uint32_t>(raw));
  }
  for (const Tpdo& tpdo : tpdos_) {
    if (result) result = tpdo.check(row, static_cast<std::uint32_t>(raw));
  }
  return result;
}

void PdoService::written(const EntryRow& row, nanoseconds now) noexcept {
  for (Rpdo& rpdo : rpdos_) rpdo.written(row);
  for (Tpdo& tpdo : tpdos_) tpdo.written(row, now);
  if (running_) select();
}

void PdoService::receive(const Frame& frame, nanoseconds now) {
  if (!running_) return;
  if (frame.kind == canopen::FrameKind::kRemote) {
    for (Tpdo& tpdo : tpdos_) {
      if (tpdo.remote(frame, now)) return;
    }
    return;
  }
  // By numbers: what the application does with the values may end the PDOs.
  for (std::size_t n = 0; running_ && n < rpdos_in_use_.size(); ++n) {
    if (rpdos_in_use_[n].identifier != frame.identifier) continue;
    const std::size_t i = rpdos_in_use_[n].place;
    application_->advance(now);
    const Rpdo::Result result = rpdos_[i].receive(frame);
    if (result == Rpdo::Result::kWaits && !rpdos_[i].synchronous()) plan_cycle(now);
    judge(i, result, now);
  }
}

/// Event-driven RPDOs are applied at the next multiple of the cycle of PDOs.
void PdoService::plan_cycle(nanoseconds now) noexcept {
  cycle_ = (now / options_->pdo_cycle + 1) * options_->pdo_cycle;
}

/// Tells of a wrong length once, and of its end with the next good message (CiA 301 Table 26).
void PdoService::judge(std::size_t number, Rpdo::Result result, nanoseconds now) {
  constexpr std::uint8_t kBits = canopen::error_register::kGeneric | canopen::error_register::kCommunication;
  const auto source = static_cast<std::uint8_t>(kFirstSource + number);
  const auto tell = [&](bool wrong, std::uint16_t code) {
    if (wrong) return emergency_->raise({code, kBits, {}}, source, true, now);
    emergency_->clear(code, source, true, now);
  };
  const bool too_short = result == Rpdo::Result::kTooShort;
  tell(too_short, canopen::emergency_code::kPdoTooShort);
  if (too_short) return;
  tell(rpdos_[number].too_long() && options_->long_rpdo_emergency, canopen::emergency_code::kPdoTooLong);
  application_->rpdo_received(number, now);
  if (result == Rpdo::Result::kApplied) application_->rpdo_applied(number, now);
}

void PdoService::apply(bool synchronous, nanoseconds now) {
  for (std::size_t n = 0; running_ && n < rpdos_in_use_.size(); ++n) {
    const std::size_t i = rpdos_in_use_[n].place;
    if (rpdos_[i].synchronous() == synchronous && rpdos_[i].apply()) application_->rpdo_applied(i, now);
  }
}

void PdoService::sample(nanoseconds now) noexcept {
  if (!running_) return;
  for (const std::size_t i : tpdos_with_sync_) tpdos_[i].sync(now);
}

void PdoService::trigger(std::size_t tpdo, nanoseconds now) noexcept {
  if (tpdo < tpdos_.size()) tpdos_[tpdo].trigger(now);
}

void PdoService::watch(nanoseconds now) noexcept {
  if (!running_) return;
  for (const std::size_t i : tpdos_with_events_) tpdos_[i].watch(application_->event_mask(i), now);
}

void PdoService::advance(nanoseconds now) {
  if (cycle_ <= now) {
    cycle_ = kNever;
    application_->advance(now);
    apply(false, now);
  }
  if (!running_) return;
  for (const std::size_t i : tpdos_with_events_) tpdos_[i].advance(now);
}

nanoseconds PdoService::next_wake() const noexcept {
  nanoseconds next = cycle_;
  if (!running_) return next;
  for (const std::size_t i : tpdos_with_events_) next = std::min(next, tpdos_[i].next_wake());
  return next;
}

}  // namespace driveline::slaves::cia301
