#pragma once

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master::dc {

/// Exchanges datagrams each of which is for one slave of `slaves`. Error beside those of the exchange: WorkingCounter,
/// with slave and register, for the first that was not answered.
[[nodiscard]] Result<void> exchange_checked(Bus& bus, std::span<const SlaveRef> slaves, std::span<Request> requests);

}  // namespace driveline::ecat_master::dc
