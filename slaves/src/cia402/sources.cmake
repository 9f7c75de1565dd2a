target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/homing_sequence.cpp
  ${CMAKE_CURRENT_LIST_DIR}/power_state_machine.cpp
  ${CMAKE_CURRENT_LIST_DIR}/profile_generator.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ratio.cpp
  ${CMAKE_CURRENT_LIST_DIR}/setpoint_handshake.cpp)
