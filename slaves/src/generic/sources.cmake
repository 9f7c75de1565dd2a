find_package(fmt REQUIRED)
target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/complete_description.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_model.cpp
  ${CMAKE_CURRENT_LIST_DIR}/generic_device.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ideal_drives.cpp
  ${CMAKE_CURRENT_LIST_DIR}/model_builder.cpp
  ${CMAKE_CURRENT_LIST_DIR}/soe_drives.cpp)
target_link_libraries(driveline_slaves PRIVATE fmt::fmt)
