#include "driveline/slaves/canopen/application.hpp"

namespace driveline::slaves::cia301 {

std::uint32_t Application::bit_rate(Reset /*reset*/) {
  return 0;
}
void Application::restart(Reset /*reset*/, nanoseconds /*now*/) {}
void Application::restore_communication() {}
nanoseconds Application::start_up_time() const noexcept {
  return nanoseconds{0};
}
void Application::advance(nanoseconds /*now*/) {}
nanoseconds Application::next_wake() const noexcept {
  return can::kNever;
}
bool Application::may_start() const noexcept {
  return true;
}
void Application::state_changed(canopen::NmtState /*state*/, nanoseconds /*now*/) {}
void Application::sync(std::uint8_t /*counter*/, nanoseconds /*now*/) {}
void Application::rpdo_received(std::size_t /*number*/, nanoseconds /*now*/) {}
void Application::rpdo_applied(std::size_t /*number*/, nanoseconds /*now*/) {}
void Application::time(const canopen::TimeOfDay& /*time*/, nanoseconds /*now*/) {}
void Application::communication(CommunicationEvent /*event*/, nanoseconds /*now*/) {}
std::uint64_t Application::event_mask(std::size_t /*tpdo*/) const noexcept {
  return ~std::uint64_t{0};
}
bool Application::keep(const ObjectDictionary& /*stored*/) {
  return true;
}

}  // namespace driveline::slaves::cia301
