# Files generated from the sources: those made by the build, and those kept in the tree and made anew on request.
include_guard()
find_package(Python3 COMPONENTS Interpreter)

# ESI files are for users of other tools: kept in the tree, compared by a test.
set(esi_data ${CMAKE_SOURCE_DIR}/esi/data)
set(esi_files moog_msd.xml servoone.xml)
list(TRANSFORM esi_files PREPEND ${esi_data}/ OUTPUT_VARIABLE kept_esi_files)
install(FILES ${kept_esi_files} DESTINATION ${CMAKE_INSTALL_DATADIR}/driveline/esi COMPONENT program)
if(NOT TARGET driveline)
  return()
endif()

set(device_files moog_msd.sii moog_msd.eds moog_msd_can.eds moog_msd_objects.md servoone.sii servoone.eds
                 servoone_can.eds servoone_objects.md servoone_idns.md servoone_junior.sii servoone_junior.eds servoone_junior_can.eds
                 moog_msd.efw servoone.efw servoone_junior.efw)
set(folder ${CMAKE_BINARY_DIR}/esi/data)
list(TRANSFORM device_files PREPEND ${folder}/)
list(TRANSFORM esi_files PREPEND ${folder}/ OUTPUT_VARIABLE made_esi_files)
add_custom_command(
  OUTPUT ${device_files} ${made_esi_files}
  COMMAND driveline esi generate ${folder} > ${CMAKE_BINARY_DIR}/esi/files.txt
  DEPENDS driveline
  COMMENT "Generating ESI, SII, EDS and object pages of the simulated drives"
  VERBATIM)
add_custom_target(device_files ALL DEPENDS ${device_files} ${made_esi_files})
add_dependencies(installed device_files)
install(FILES ${device_files} DESTINATION ${CMAKE_INSTALL_DATADIR}/driveline/esi COMPONENT program)

# Generated files kept in the tree; each is compared by a test.
if(Python3_FOUND)
  add_custom_target(regenerate
    COMMAND ${CMAKE_COMMAND} -E copy_if_different ${made_esi_files} ${esi_data}
    COMMAND Python3::Interpreter ${CMAKE_SOURCE_DIR}/examples/make_line8_path.py
    COMMAND Python3::Interpreter -B ${CMAKE_SOURCE_DIR}/scripts/bench_tables.py
    DEPENDS ${made_esi_files}
    WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}
    VERBATIM)
endif()
