find_package(fmt REQUIRED)
target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/application.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device.cpp
  ${CMAKE_CURRENT_LIST_DIR}/eds_device.cpp
  ${CMAKE_CURRENT_LIST_DIR}/eds_model.cpp
  ${CMAKE_CURRENT_LIST_DIR}/eds_model_builder.cpp
  ${CMAKE_CURRENT_LIST_DIR}/emergency_service.cpp
  ${CMAKE_CURRENT_LIST_DIR}/entry.cpp
  ${CMAKE_CURRENT_LIST_DIR}/error_control.cpp
  ${CMAKE_CURRENT_LIST_DIR}/heartbeat_consumer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/nmt_machine.cpp
  ${CMAKE_CURRENT_LIST_DIR}/outbox.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pdo_service.cpp
  ${CMAKE_CURRENT_LIST_DIR}/rpdo.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sdo_block_transfer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sdo_server.cpp
  ${CMAKE_CURRENT_LIST_DIR}/store.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sync_service.cpp
  ${CMAKE_CURRENT_LIST_DIR}/tpdo.cpp)
target_link_libraries(driveline_slaves PRIVATE fmt::fmt)
