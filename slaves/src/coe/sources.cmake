target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/coe_access.cpp
  ${CMAKE_CURRENT_LIST_DIR}/complete_access.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sdo_information.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sdo_server.cpp)
