target_sources(driveline_slaves PRIVATE ${CMAKE_CURRENT_LIST_DIR}/power_state_machine.cpp)
