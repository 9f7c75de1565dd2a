target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/pdo_map.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pdo_settings.cpp)
