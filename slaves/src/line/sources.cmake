list(APPEND DRIVELINE_SLAVES_SOURCES
  src/line/fault.cpp
  src/line/frame_datagrams.cpp
  src/line/frame_path.cpp
  src/line/line_end.cpp
  src/line/line_faults.cpp
  src/line/simulated_line.cpp
  src/line/wiring.cpp)
