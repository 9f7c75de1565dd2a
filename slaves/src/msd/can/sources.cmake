# The CANopen front end.
target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/can_indicators.cpp
  ${CMAKE_CURRENT_LIST_DIR}/can_description.cpp
  ${CMAKE_CURRENT_LIST_DIR}/can_table.cpp
  ${CMAKE_CURRENT_LIST_DIR}/msd_can_drive.cpp
  ${CMAKE_CURRENT_LIST_DIR}/rpdo_uses.cpp
  ${CMAKE_CURRENT_LIST_DIR}/telegram_watch.cpp)
