# The commit that is built; empty outside a checkout unless it is given: -DDRIVELINE_COMMIT=...
include_guard()
set(DRIVELINE_COMMIT "" CACHE STRING "Commit that is built, where it cannot be asked of git")
set(commit ${DRIVELINE_COMMIT})
if(NOT commit)
  execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} rev-parse --short=12 --verify --quiet HEAD
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  # The log of HEAD changes with every commit.
  execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} rev-parse --git-path logs/HEAD
                  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE head_log OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(head_log)
    get_filename_component(head_log ${head_log} ABSOLUTE BASE_DIR ${PROJECT_SOURCE_DIR})
    if(EXISTS ${head_log})
      set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${head_log})
    endif()
  endif()
endif()
# How it is built, as the figures of benchmarks and `--version` tell.
set(build ${CMAKE_BUILD_TYPE})
if(DRIVELINE_LTO)
  string(APPEND build ", LTO")
endif()
