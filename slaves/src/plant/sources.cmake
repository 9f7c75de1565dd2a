target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/current_loop.cpp
  ${CMAKE_CURRENT_LIST_DIR}/dc_link.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mechanics.cpp
  ${CMAKE_CURRENT_LIST_DIR}/screw.cpp
  ${CMAKE_CURRENT_LIST_DIR}/servo_controller.cpp
  ${CMAKE_CURRENT_LIST_DIR}/servo_motor.cpp
  ${CMAKE_CURRENT_LIST_DIR}/thermal_model.cpp
  ${CMAKE_CURRENT_LIST_DIR}/voltage_frequency.cpp)
