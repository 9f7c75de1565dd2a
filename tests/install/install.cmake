# Installs the build tree BUILD into an empty PREFIX and looks whether everything is there.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
set(program)
if(PROGRAM)
  set(program bin/driveline share/bash-completion/completions/driveline share/zsh/site-functions/_driveline
              share/man/man1/driveline.1 share/man/man1/driveline-esi-show.1 lib/systemd/system/driveline@.service
              lib/udev/rules.d/60-driveline.rules
              libexec/driveline/driveline-endpoint share/driveline/esi/moog_msd.eds share/driveline/esi/servoone_junior.sii)
endif()
if(BRIDGE)
  list(APPEND program libexec/driveline/driveline-bridge libexec/driveline/driveline-dds)
endif()
foreach(wanted
        include/driveline/ecat_master/master.hpp
        include/driveline/runtime/line.hpp
        include/driveline/runtime/devices/device_family.hpp
        include/driveline/wire/registers.hpp
        include/driveline/slaves/line/simulated_line.hpp
        include/driveline/stream/client.hpp
        share/driveline/stream_client/driveline/stream/client.hpp
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
# A program that streams setpoints needs one installed folder of headers and links nothing.
execute_process(COMMAND ${COMPILER} -std=c++20 -Wall -Wextra -Werror -I${PREFIX}/share/driveline/stream_client
                        ${PREFIX}/share/driveline/examples/10_stream_client.cpp -o ${PREFIX}/10_stream_client
                COMMAND_ERROR_IS_FATAL ANY)
