# Copies the headers of the client into an empty FOLDER, and compiles each of them, and the example, with that alone.
file(REMOVE_RECURSE ${FOLDER})
foreach(header IN LISTS HEADERS)
  string(REGEX REPLACE "^.*/include/" "" name ${header})
  cmake_path(GET name PARENT_PATH parent)
  file(COPY ${header} DESTINATION ${FOLDER}/${parent})
  list(APPEND names ${name})
endforeach()
foreach(name IN LISTS names)
  set(one ${FOLDER}/one_header.cpp)
  file(WRITE ${one} "#include \"${name}\"\n")
  execute_process(COMMAND ${COMPILER} -std=c++20 -Wall -Wextra -Werror -I${FOLDER} -fsyntax-only ${one}
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
execute_process(COMMAND ${COMPILER} -std=c++20 -Wall -Wextra -Werror -I${FOLDER}
                        ${SOURCE_TREE}/examples/10_stream_client.cpp -o ${FOLDER}/10_stream_client
                COMMAND_ERROR_IS_FATAL ANY)
