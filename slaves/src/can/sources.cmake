target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/broadcast_manager.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bus.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bus_faults.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bus_off_recovery.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cannelloni_door.cpp
  ${CMAKE_CURRENT_LIST_DIR}/controller.cpp
  ${CMAKE_CURRENT_LIST_DIR}/door.cpp
  ${CMAKE_CURRENT_LIST_DIR}/error_counters.cpp
  ${CMAKE_CURRENT_LIST_DIR}/segment.cpp
  ${CMAKE_CURRENT_LIST_DIR}/slcan_door.cpp
  ${CMAKE_CURRENT_LIST_DIR}/socketcand_door.cpp
  ${CMAKE_CURRENT_LIST_DIR}/transmit_queue.cpp
  ${CMAKE_CURRENT_LIST_DIR}/wiring.cpp)
