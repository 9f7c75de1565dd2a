#pragma once

#include <optional>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"

namespace driveline::runtime {

/// Identity and configuration in a [[slave]] of a line description, in addition to vendor and product:
///
///   alias = 7                      device_id = 3            lrw = false
///   eeprom_to_application = true   (the application gets the EEPROM interface before PREOP)
///   hot_connect = true             (may be missing, and comes and goes)
///   hot_connect = "NAME"           (the same, after that slave, in the hot-connect group that it heads)
///   revision = ">= 0x00010000"     serial = 4711            (numbers, ">= ..." or "any")
///   [slave.watchdog]               process_data_ms, pdi_ms  (0 is off)
///   state_timeout_ms = 30000       (to SAFEOP and to OP, unless [slave.timeouts] says otherwise)
///   [slave.timeouts]               preop_ms, safeop_ms, op_ms, back_to_init_ms, back_to_safeop_ms,
///                                  mailbox_request_ms, mailbox_response_ms, mailbox_repeat_ms (0 is never)
///   [slave.startup]                sync_objects, interpolation_time, pdo_assignment, pdo_mapping: "mandatory",
///                                  "optional" or "omit"; safeop_retries
///   [[slave.sdo]]                  index, subindex, type, value, complete, optional, before = "safeop" or "op"
///   [[slave.idn]]                  drive, number = "S-0-0044", value (number, text, list) or data = "0A 00",
///                                  transition = "PS" or "SO", read_back
///   [[slave.pdo]]                  index, sync_manager, direction = "out" or "in", entries = ["0x6040:0:16", ...]
struct SlavePlanConfig {
  ecat_master::IdentityRule revision;      ///< accepted revisions
  ecat_master::IdentityRule serial;        ///< accepted serial numbers
  std::optional<std::uint16_t> alias;      ///< station alias that identifies it
  std::optional<std::uint16_t> device_id;  ///< explicit device ID that identifies it
  bool hot_connect = false;                ///< may be missing, and comes and goes
  std::string hot_head;                    ///< name of the slave that heads its hot-connect group; empty: no group
  std::optional<ecat_master::HotConnectPlace> behind;  ///< number of the hot_head slave, and place in the group
  ecat_master::WatchdogPlan watchdog;                  ///< values that are left out keep the setting of the slave
  ecat_master::StateTimeouts timeouts;                 ///< values that are left out: see StateTimeouts
  ecat_master::MailboxTimeouts mailbox_timeouts;       ///< values that are left out: see MailboxTimeouts
  ecat_master::StartupNeeds needs;                     ///< writes that the slave may refuse
  motion::WriteNeed interpolation_time = motion::WriteNeed::kOptional;  ///< need of 60C2h of an axis
  ecat_master::StateRetries safe_op_retries;                            ///< repeated requests of SAFEOP
  std::optional<bool> lrw;                       ///< false: no LRW for this slave; none: its description decides
  std::optional<bool> eeprom_to_application;     ///< see SlavePlan::eeprom_to_application
  std::vector<motion::StartupSdo> sdos;          ///< in the order of the file
  std::vector<ecat_master::StartupIdn> idns{};   ///< in the order of the file
  std::optional<motion::PdoConfiguration> pdos;  ///< none: the PDOs that the use of the slave requires

  /// Adds these settings to `plan`: start-up SDOs are appended, PDOs replaced, and `interpolation_time` applies to the
  /// start-up SDOs that `plan` has before.
  void apply(ecat_master::SlavePlan& plan) const;
};

}  // namespace driveline::runtime
