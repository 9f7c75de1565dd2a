target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/coe_server.cpp
  ${CMAKE_CURRENT_LIST_DIR}/eoe_server.cpp
  ${CMAKE_CURRENT_LIST_DIR}/foe_server.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mailbox_server.cpp
  ${CMAKE_CURRENT_LIST_DIR}/soe_server.cpp)
