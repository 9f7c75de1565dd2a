# The EtherCAT front end; core/ has the drive itself, can/ the CANopen front end, sercos/ the table of its IDNs.
target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/device_description.cpp
  ${CMAKE_CURRENT_LIST_DIR}/drive_files.cpp
  ${CMAKE_CURRENT_LIST_DIR}/drive_status.cpp
  ${CMAKE_CURRENT_LIST_DIR}/indicators.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mode_mapping.cpp
  ${CMAKE_CURRENT_LIST_DIR}/msd_drive.cpp
  ${CMAKE_CURRENT_LIST_DIR}/msd_table.cpp
  ${CMAKE_CURRENT_LIST_DIR}/object_description.cpp
  ${CMAKE_CURRENT_LIST_DIR}/object_reference.cpp
  ${CMAKE_CURRENT_LIST_DIR}/table_ethercat.cpp)
include(${CMAKE_CURRENT_LIST_DIR}/core/sources.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/can/sources.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/sercos/sources.cmake)
