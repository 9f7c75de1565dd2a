#pragma once

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master::dc {

/// Exchanges datagrams that each address one slave of `slaves`. Errors: those of the exchange; WorkingCounter, with
/// slave and register, for the first unanswered datagram.
[[nodiscard]] Result<void> exchange_checked(Bus& bus, std::span<const SlaveRef> slaves, std::span<Request> requests);

}  // namespace driveline::ecat_master::dc
