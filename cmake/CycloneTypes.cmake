# cyclone_driveline_types: the types of the telemetry as Cyclone DDS's own compiler makes them of our IDL, for tests and
# benchmarks. Included where they are needed.
include_guard(GLOBAL)
find_package(CycloneDDS REQUIRED)

idlc_generate(TARGET cyclone_driveline_idl FILES ${PROJECT_SOURCE_DIR}/bridge/idl/driveline.idl
                                                 ${PROJECT_SOURCE_DIR}/bridge/idl/ros2.idl)
add_library(cyclone_driveline_types STATIC) # a target of its own keeps our warnings off the generated code
target_include_directories(cyclone_driveline_types SYSTEM PUBLIC ${CMAKE_CURRENT_BINARY_DIR})
target_link_libraries(cyclone_driveline_types PUBLIC CycloneDDS::ddsc PRIVATE cyclone_driveline_idl)
if(DRIVELINE_SANITIZE MATCHES thread)
  # Debian's Cyclone DDS is not instrumented: everything that is shared with it would look like a race.
  target_compile_options(cyclone_driveline_types PRIVATE -fno-sanitize=thread)
  target_link_options(cyclone_driveline_types PRIVATE -fno-sanitize=thread)
endif()
