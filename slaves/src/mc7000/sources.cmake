target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/posmod_location.cpp
  ${CMAKE_CURRENT_LIST_DIR}/process_values.cpp
  ${CMAKE_CURRENT_LIST_DIR}/program.cpp
  ${CMAKE_CURRENT_LIST_DIR}/program_line.cpp
  ${CMAKE_CURRENT_LIST_DIR}/program_run.cpp
  ${CMAKE_CURRENT_LIST_DIR}/program_store.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sequence_control.cpp)
