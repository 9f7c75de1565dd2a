# Settings common to all targets of driveline, and the functions that declare rooms, tests and benchmarks.
include_guard()
find_package(Threads REQUIRED)

# Generated sources, for checks that read our sources without compiling them (scripts/check-tidy.sh).
add_custom_target(generated_sources)

# What one checkout has compiled serves the others on the machine: paths below the checkout count from it.
find_program(DRIVELINE_CCACHE ccache)
if(DRIVELINE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${DRIVELINE_CCACHE})
endif()
# So does __FILE__, which the assertions of the tests contain.
add_compile_options(-fmacro-prefix-map=${CMAKE_SOURCE_DIR}/=)

# Warnings are errors in our own code; generated and third-party code does not link this target.
add_library(driveline_warnings INTERFACE)
target_compile_options(driveline_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror)

if(DRIVELINE_SANITIZE)
  add_compile_options(-fsanitize=${DRIVELINE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${DRIVELINE_SANITIZE})
  # The standard library checks its preconditions, too: an empty optional that is read is no error of memory.
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
endif()

# Nothing replaces a function of ours at run time, and nothing reads errno after a function of the maths library. Told so,
# the compiler may inline what it compiles as position-independent code, and rounds without a call; results are the same.
add_compile_options($<$<CONFIG:Release>:-fno-semantic-interposition> $<$<CONFIG:Release>:-fno-math-errno>)

# Every library of the fuzz build reports its coverage to libFuzzer; only the fuzz targets link its main().
if(DRIVELINE_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    message(FATAL_ERROR "DRIVELINE_FUZZ needs clang: cmake --preset fuzz")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# Sources are compiled in groups, so that their headers are read once for each group: that takes a third of the time. A group
# is one folder of a room or several small ones, so names in anonymous namespaces are unique within a room.
# DRIVELINE_UNITY=OFF compiles every file by itself, which is better while one of them is edited.
option(DRIVELINE_UNITY "Compile sources in groups" ON)
set(DRIVELINE_GROUP_BYTES 130000) # of source text: more is slow to compile again, less reads headers too often
function(driveline_group_sources target)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources EXCLUDE REGEX "^\\$<") # objects of another target
  set(folders)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH folder)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE file)
    string(MAKE_C_IDENTIFIER "${folder}" key)
    if(NOT key IN_LIST folders)
      list(APPEND folders ${key})
      set(bytes_of_${key} 0)
    endif()
    list(APPEND sources_of_${key} ${source})
    if(EXISTS ${file}) # others are generated
      file(SIZE ${file} size)
      math(EXPR bytes_of_${key} "${bytes_of_${key}} + ${size}")
    endif()
  endforeach()
  set(group 0)
  set(bytes ${DRIVELINE_GROUP_BYTES})
  foreach(key IN LISTS folders)
    math(EXPR with_folder "${bytes} + ${bytes_of_${key}}")
    if(with_folder GREATER DRIVELINE_GROUP_BYTES)
      math(EXPR group "${group} + 1")
      set(with_folder ${bytes_of_${key}})
    endif()
    set(bytes ${with_folder})
    set_source_files_properties(${sources_of_${key}} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${DRIVELINE_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()

# driveline_optimise(<target> <level>)
# Release builds compile the target with -O<level> instead of -O3: where speed matters less than the time to compile.
function(driveline_optimise target level)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O${level}>)
endfunction()

# driveline_room(<name> [INTERNAL] [COMPONENT <name>] [SOURCES ...] [COLD_SOURCES ...] [LINK ...] [PRIVATE_LINK ...])
# Declares the library driveline_<name> (alias driveline::<name>) of the current folder: headers in
# include/driveline/<name>/, implementation in the listed sources. Without sources it is header-only. It is installed
# with its headers, for find_package(driveline), unless it is INTERNAL; with COMPONENT only for
# find_package(driveline COMPONENTS <name>), because it needs packages that the other rooms do not.
# COLD_SOURCES: sources of which the cycle runs nothing; release builds compile them with -O1.
function(driveline_room name)
  cmake_parse_arguments(ARG "INTERNAL" "COMPONENT" "SOURCES;COLD_SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  set(target driveline_${name})
  set(headers $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  if(ARG_SOURCES)
    add_library(${target} STATIC ${ARG_SOURCES})
    target_include_directories(${target} PUBLIC ${headers} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
    # When all its sources are known; the call would otherwise see `target` as it is then.
    cmake_language(EVAL CODE "cmake_language(DEFER CALL driveline_group_sources ${target})")
    target_link_libraries(${target} PUBLIC ${ARG_LINK}
                                    PRIVATE ${ARG_PRIVATE_LINK} $<BUILD_INTERFACE:driveline_warnings>)
    if(ARG_COLD_SOURCES)
      add_library(${target}_cold OBJECT ${ARG_COLD_SOURCES})
      target_include_directories(${target}_cold PRIVATE include src)
      target_link_libraries(${target}_cold PRIVATE ${ARG_LINK} ${ARG_PRIVATE_LINK} driveline_warnings)
      driveline_optimise(${target}_cold 1)
      driveline_group_sources(${target}_cold)
      target_sources(${target} PRIVATE $<TARGET_OBJECTS:${target}_cold>)
    endif()
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${headers})
    target_link_libraries(${target} INTERFACE ${ARG_LINK})
  endif()
  add_library(driveline::${name} ALIAS ${target})
  if(NOT ARG_INTERNAL)
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    target_compile_features(${target} INTERFACE cxx_std_20)
    string(JOIN _ export driveline ${ARG_COMPONENT})
    install(TARGETS ${target} EXPORT ${export})
    set_property(GLOBAL APPEND PROPERTY DRIVELINE_INSTALLED ${target})
    install(DIRECTORY include/ TYPE INCLUDE)
  endif()
endfunction()

# driveline_test(<name> LABEL <unit|bus|replay|interop|fuzz|rt> SOURCES ... [ALONE ...] LINK ...)
# One GoogleTest program; every test case becomes a ctest entry carrying the label. ALONE: sources whose helpers have
# names that others in the program have, too.
function(driveline_test name)
  cmake_parse_arguments(ARG "SERIAL" "LABEL;TIMEOUT" "SOURCES;ALONE;LINK" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 60)
  endif()
  if(DRIVELINE_SANITIZE) # slower, and beside other work; the limit only ends a test that hangs
    math(EXPR ARG_TIMEOUT "5 * ${ARG_TIMEOUT}")
  endif()
  add_executable(${name} ${ARG_SOURCES} ${ARG_ALONE})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${DRIVELINE_UNITY} UNITY_BUILD_BATCH_SIZE 10)
  driveline_optimise(${name} 1)
  if(DRIVELINE_SANITIZE) # clang takes half of its time for the optimisation of assertions
    target_compile_options(${name} PRIVATE -O0)
  endif()
  if(ARG_ALONE)
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gmock_main driveline_warnings)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests) # for tests/support
  set(properties LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
  if(ARG_SERIAL)
    list(APPEND properties RUN_SERIAL TRUE)
  endif()
  if(DRIVELINE_SANITIZE) # a third of each campaign's runs (tests/support/campaign.hpp); the release build makes all
    list(APPEND properties ENVIRONMENT DRIVELINE_CAMPAIGN_SHARE=3)
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}
                       PROPERTIES ${properties})
endfunction()

# driveline_bench(<name> SOURCES ... LINK ...)
# One benchmark program in <build>/bench/.
function(driveline_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(bench_${name} ${ARG_SOURCES})
  set_target_properties(bench_${name} PROPERTIES OUTPUT_NAME ${name}
                        RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bench)
  target_link_libraries(bench_${name} PRIVATE ${ARG_LINK} driveline_warnings)
endfunction()
