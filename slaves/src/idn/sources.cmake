target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/idn_dictionary.cpp
  ${CMAKE_CURRENT_LIST_DIR}/idn_table.cpp
  ${CMAKE_CURRENT_LIST_DIR}/idn_values.cpp)
