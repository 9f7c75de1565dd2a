#include "support/options.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <exception>

namespace driveline::bench {

int run(int argc, char** argv, const char* question, void (*measure)(const Options& options)) {
  Options options;
  CLI::App app{question};
  app.add_flag("--json", options.json, "Print one JSON document");
  app.add_flag("--quick", options.quick, "A tenth of the measurements, to see that it works");
  app.add_option("--figures", options.figures, "Folder for curves instead of a report (dc)");
  app.add_option("--histogram", options.histogram, "File for the measured histogram (wake)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    measure(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", argv[0], error.what());
    return 1;
  }
  return 0;
}

}  // namespace driveline::bench
