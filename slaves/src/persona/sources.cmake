target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/eeprom_edit.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mailbox_habits.cpp
  ${CMAKE_CURRENT_LIST_DIR}/persona_device.cpp
  ${CMAKE_CURRENT_LIST_DIR}/persona_slave.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sdo_obstacles.cpp)
