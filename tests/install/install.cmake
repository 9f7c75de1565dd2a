# Installs the build tree BUILD into an empty PREFIX and looks whether everything is there.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
set(program)
if(PROGRAM)
  set(program bin/driveline share/bash-completion/completions/driveline share/zsh/site-functions/_driveline
              libexec/driveline/driveline-endpoint share/driveline/esi/moog_msd.eds share/driveline/esi/servoone_junior.sii)
endif()
foreach(wanted
        include/driveline/ecat_master/master.hpp
        include/driveline/runtime/line.hpp
        include/driveline/runtime/devices/device_family.hpp
        include/driveline/wire/registers.hpp
        include/driveline/slaves/line/line.hpp
        share/driveline/examples/01_scan.cpp
        share/driveline/examples/line8.toml
        share/driveline/esi/moog_msd.xml
        share/driveline/esi/servoone.xml
        ${program})
  if(NOT EXISTS ${PREFIX}/${wanted})
    message(FATAL_ERROR "${wanted} has not been installed")
  endif()
endforeach()
file(GLOB_RECURSE headers ${PREFIX}/include/driveline/cli/*)
if(headers)
  message(FATAL_ERROR "headers of the program have been installed: ${headers}")
endif()
file(GLOB_RECURSE targets ${PREFIX}/*/drivelineTargets*.cmake)
foreach(file ${targets})
  file(READ ${file} text)
  string(FIND "${text}" "${BUILD}" place)
  if(NOT place EQUAL -1)
    message(FATAL_ERROR "${file} refers to the build tree")
  endif()
endforeach()
