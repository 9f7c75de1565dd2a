list(APPEND DRIVELINE_SLAVES_SOURCES
  src/esc/al_state_machine.cpp
  src/esc/distributed_clock.cpp
  src/esc/esc.cpp
  src/esc/esc_datagrams.cpp
  src/esc/esc_registers.cpp
  src/esc/fmmu_unit.cpp
  src/esc/mailbox_transport.cpp
  src/esc/sii_interface.cpp
  src/esc/slave.cpp
  src/esc/sync_manager_check.cpp
  src/esc/sync_manager_unit.cpp
  src/esc/watchdog_unit.cpp)
