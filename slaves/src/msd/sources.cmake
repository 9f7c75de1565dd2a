target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/device_description.cpp
  ${CMAKE_CURRENT_LIST_DIR}/faults.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fine_interpolator.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mode_control.cpp
  ${CMAKE_CURRENT_LIST_DIR}/motion.cpp
  ${CMAKE_CURRENT_LIST_DIR}/msd_drive.cpp
  ${CMAKE_CURRENT_LIST_DIR}/msd_objects.cpp
  ${CMAKE_CURRENT_LIST_DIR}/msd_power.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scaling.cpp
  ${CMAKE_CURRENT_LIST_DIR}/table_communication.cpp
  ${CMAKE_CURRENT_LIST_DIR}/table_modes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/table_parameters.cpp
  ${CMAKE_CURRENT_LIST_DIR}/table_profile.cpp
  ${CMAKE_CURRENT_LIST_DIR}/table_terminals.cpp
  ${CMAKE_CURRENT_LIST_DIR}/terminals.cpp)
