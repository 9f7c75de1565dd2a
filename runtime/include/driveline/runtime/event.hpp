#pragma once

// Events, and all kinds of facts they can have.
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/runtime/event/can_events.hpp"
#include "driveline/runtime/event/command_events.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/runtime/event/group_events.hpp"
#include "driveline/runtime/event/operation_events.hpp"
#include "driveline/runtime/event/result_events.hpp"
#include "driveline/runtime/event/service_events.hpp"
#include "driveline/runtime/event/set_up_events.hpp"
#include "driveline/runtime/event/stream_events.hpp"
#include "driveline/runtime/event/telemetry_events.hpp"
