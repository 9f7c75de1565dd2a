#include <exception>

#include "console.hpp"
#include "process_limits.hpp"
#include "program.hpp"

int main(int argc, char** argv) {
  try {
    return driveline::cli::run_program(argc, argv);
  } catch (const std::exception& error) {
    driveline::cli::progress("driveline: {}", driveline::cli::describe_end(error));
    return 1;
  }
}
