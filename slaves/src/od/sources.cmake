target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/dictionary_table.cpp
  ${CMAKE_CURRENT_LIST_DIR}/object_dictionary.cpp
  ${CMAKE_CURRENT_LIST_DIR}/parameter_file.cpp)
