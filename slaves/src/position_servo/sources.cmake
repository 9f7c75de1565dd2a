target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/homing.cpp
  ${CMAKE_CURRENT_LIST_DIR}/motion.cpp
  ${CMAKE_CURRENT_LIST_DIR}/segment.cpp
  ${CMAKE_CURRENT_LIST_DIR}/travel_limits.cpp)
