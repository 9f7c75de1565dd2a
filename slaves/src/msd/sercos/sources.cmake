target_sources(driveline_slaves PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/core_values.cpp
  ${CMAKE_CURRENT_LIST_DIR}/idn_reference.cpp
  ${CMAKE_CURRENT_LIST_DIR}/idns_product.cpp
  ${CMAKE_CURRENT_LIST_DIR}/idns_standard.cpp
  ${CMAKE_CURRENT_LIST_DIR}/phase_checks.cpp
  ${CMAKE_CURRENT_LIST_DIR}/servoone_dictionary.cpp
  ${CMAKE_CURRENT_LIST_DIR}/servoone_idns.cpp)
