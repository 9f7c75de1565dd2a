# Installed beside the rooms: the package for find_package(driveline), the program, its
# completion, and the examples.
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/driveline)
install(EXPORT driveline FILE drivelineTargets.cmake NAMESPACE driveline:: DESTINATION ${package_folder})
if(TARGET driveline_bridge)
  install(EXPORT driveline_bridge FILE drivelineBridgeTargets.cmake NAMESPACE driveline:: DESTINATION ${package_folder})
endif()
configure_package_config_file(cmake/drivelineConfig.cmake.in ${CMAKE_BINARY_DIR}/drivelineConfig.cmake
                              INSTALL_DESTINATION ${package_folder})
# Before 1.0 every minor version may break.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/drivelineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/drivelineConfig.cmake ${CMAKE_BINARY_DIR}/drivelineConfigVersion.cmake
        DESTINATION ${package_folder})

install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/driveline/examples COMPONENT program
        PATTERN CMakeLists.txt EXCLUDE)

if(TARGET driveline)
  install(TARGETS driveline COMPONENT program)
  install(FILES ${CMAKE_BINARY_DIR}/completion/driveline
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
  install(FILES ${CMAKE_BINARY_DIR}/completion/_driveline
          DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT program)
endif()

# Everything that is installed.
get_property(rooms GLOBAL PROPERTY DRIVELINE_INSTALLED)
add_custom_target(installed)
foreach(target ${rooms} driveline_bridge_idl driveline driveline_completion driveline_manual driveline-bridge driveline-dds
               driveline-endpoint)
  if(TARGET ${target})
    get_target_property(type ${target} TYPE)
    if(NOT type STREQUAL INTERFACE_LIBRARY)
      add_dependencies(installed ${target})
    endif()
  endif()
endforeach()
