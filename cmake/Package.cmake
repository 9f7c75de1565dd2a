# Debian packages: `scripts/package.sh` builds and calls cpack. driveline is the program with its service,
# driveline-bridge what publishes and reads over DDS, and libdriveline-dev the library (static), with what other programs
# need to be built on it.
include_guard()
if(NOT TARGET driveline)
  return()
endif()

# The service, the rights of its user, the manual; and what Debian's policy asks of a package. They name the place where
# they are installed, which is known only then: `cmake --install --prefix` and cpack choose it.
set(packaging ${CMAKE_SOURCE_DIR}/packaging)
set(manual ${CMAKE_BINARY_DIR}/manual)
install(FILES ${packaging}/60-driveline.rules DESTINATION lib/udev/rules.d COMPONENT program)
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(AT @)
set(components program dev)
if(TARGET driveline-bridge)
  list(APPEND components bridge)
endif()
foreach(component ${components})
  set(package_component ${component})
  configure_file(${packaging}/install.cmake.in ${CMAKE_BINARY_DIR}/packaging/install_${component}.cmake @ONLY)
  install(SCRIPT ${CMAKE_BINARY_DIR}/packaging/install_${component}.cmake COMPONENT ${component})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME driveline)
set(CPACK_PACKAGE_VENDOR "driveline maintainers")
set(CPACK_PACKAGE_CONTACT "driveline maintainers <maintainers@driveline.invalid>")
set(CPACK_PACKAGE_HOMEPAGE_URL "")
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME driveline)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS adduser)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "driveline-bridge, gnuplot-nox, ethtool, iproute2")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "real-time EtherCAT master for servo drive lines
Runs lines of EtherCAT servo drives: states, mailbox, distributed clocks,
process data every 125 us from a pinned real-time thread, and setpoints in
CSP, CSV and CST. The same program simulates the drives, in its process or
served on a network interface to any other master.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${packaging}/postinst ${packaging}/prerm ${packaging}/postrm)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_BRIDGE_PACKAGE_NAME driveline-bridge)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_DEPENDS "driveline (= ${PROJECT_VERSION}-1)")
set(CPACK_DEBIAN_BRIDGE_DESCRIPTION "telemetry of servo drive lines over DDS
Publishes what the lines of driveline do, with Fast DDS, from a process
without privileges that the real-time program starts and supervises, and
shows and records it on any machine.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libdriveline-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libeigen3-dev, libexpected-dev, libfmt-dev, libpugixml-dev, libtomlplusplus-dev, libfastrtps-dev, libfastcdr-dev, libtinyxml2-dev")
set(CPACK_DEBIAN_DEV_DESCRIPTION "real-time EtherCAT master for servo drive lines - development files
Headers, static libraries and the CMake package of driveline, for programs
that run a drive line themselves or add drives of another make.")
include(CPack)
