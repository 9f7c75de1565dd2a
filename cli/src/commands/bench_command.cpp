#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "text/bench_comparison.hpp"
#include "text/bench_html.hpp"
#include "text/bench_report.hpp"
#include "text/gnuplot.hpp"
#include "text/json_text.hpp"

extern char** environ;

namespace driveline::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kWhereFrom =
    "build the benchmark programs in a source tree (`cmake --preset release`, `cmake --build build`), and name their "
    "folder with --dir "
    "(build/bench)";

struct Options {
  std::vector<std::string> names;
  std::optional<std::string> directory;
  std::optional<std::string> output;
  bool quick = false;
  bool full = false;
  bool compare = false;
  bool json = false;
  bool list = false;
};

/// The amount of measurements of a program.
enum class Extent : std::uint8_t { kFull, kShort, kQuick };

/// The build puts the programs of bench/ into a folder of that name beside this program.
fs::path default_directory() {
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path("bench") : program.parent_path() / "bench";
}

/// The programs in `directory`, sorted by name.
Outcome<std::vector<fs::path>> find_programs(const fs::path& directory) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (!entry.is_regular_file() || entry.path().has_extension()) continue;
    if (access(entry.path().c_str(), X_OK) == 0) found.push_back(entry.path());
  }
  if (error) {
    return misused(fmt::format("{}: {}; {}", directory.string(), error.message(), kWhereFrom));
  }
  if (found.empty())
    return misused(fmt::format("{}: contains no benchmark program; {}", directory.string(), kWhereFrom));
  std::sort(found.begin(), found.end());
  return found;
}

/// The programs named on the command line; all if none is named.
Outcome<std::vector<fs::path>> select(const std::vector<fs::path>& programs, const std::vector<std::string>& names) {
  if (names.empty()) return programs;
  std::vector<fs::path> chosen;
  for (const auto& name : names) {
    const auto found =
        std::find_if(programs.begin(), programs.end(), [&](const auto& p) { return p.filename() == name; });
    if (found == programs.end()) {
      std::string known;
      for (const auto& program : programs) known += (known.empty() ? "" : ", ") + program.filename().string();
      return misused(fmt::format("there is no benchmark '{}'; choose from {}", name, known));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

/// Exit status of a program that cannot measure everything on this machine (bench/support/options.hpp).
constexpr int kSkipped = 77;

/// Standard output of a program, and whether it measured everything.
struct Output {
  std::string text;
  bool skipped = false;
};

/// Runs a program, which shares stderr with this one. Error: a sentence.
tl::expected<Output, std::string> output_of(const fs::path& program, Extent extent) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return tl::unexpected(std::string("no pipe could be created"));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addclose(&actions, ends[0]);
  posix_spawn_file_actions_addclose(&actions, ends[1]);
  std::array<std::string, 3> words{program.string(), "--json", extent == Extent::kQuick ? "--quick" : "--short"};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), extent == Extent::kFull ? nullptr : words[2].data(),
                                 nullptr};
  pid_t pid = 0;
  const int refused = posix_spawn(&pid, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string text;
  std::array<char, 4096> part{};
  for (ssize_t size = 0; refused == 0 && (size = read(ends[0], part.data(), part.size())) != 0;) {
    if (size > 0) text.append(part.data(), static_cast<std::size_t>(size));
    if (size < 0 && errno != EINTR) break;
  }
  close(ends[0]);
  if (refused != 0)
    return tl::unexpected(fmt::format("cannot be started: {}", std::generic_category().message(refused)));
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return tl::unexpected(fmt::format("was terminated by signal {}", WTERMSIG(status)));
  const int code = WEXITSTATUS(status);
  if (code != 0 && code != kSkipped) return tl::unexpected(fmt::format("failed with status {}", code));
  return Output{std::move(text), code == kSkipped};
}

/// The content of a picture; empty: it cannot be read.
std::string picture_in(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Writes documents, report and pictures. Without gnuplot only the pictures are missing.
Outcome<void> write_output(const fs::path& directory, const std::vector<json>& documents) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return failed(fmt::format("{}: cannot be created: {}", directory.string(), error.message()));
  const auto write = [&](const std::string& name, const std::string& content) -> Outcome<void> {
    if (auto done = runtime::write_file(directory / name, content); !done) return tl::unexpected(done.error());
    print_line((directory / name).string());
    return {};
  };
  auto report = bench_report(documents);
  std::map<std::string, std::string> pictures;
  for (const auto& document : documents) {
    if (auto done = write(document["bench"].get<std::string>() + ".json", document.dump(2) + "\n"); !done) return done;
  }
  for (const auto& figure : bench_figures(documents)) {
    if (auto done = write(figure.name + ".dat", figure.data); !done) return done;
    if (auto done = write(figure.name + ".gp", figure.script); !done) return done;
    if (auto drawn = run_gnuplot(directory, figure.name + ".gp"); !drawn) {
      print_line(drawn.error());
      continue;
    }
    report += fmt::format("\n![{0}]({0}.svg)\n", figure.name);
    pictures[figure.name] = picture_in(directory / (figure.name + ".svg"));
  }
  if (auto done = write("report.md", report); !done) return done;
  if (auto done = write("report.json", json{{"benches", documents}}.dump(1) + "\n"); !done) return done;
  return write("report.html", bench_html(documents, pictures));
}

/// Reads the documents of a report.json, or of a folder with one file per document.
Outcome<std::vector<json>> read_bench_documents(const fs::path& where) {
  std::vector<fs::path> files;
  std::error_code error;
  if (fs::is_directory(where, error)) {
    for (const auto& entry : fs::directory_iterator(where, error)) {
      if (entry.path().extension() == ".json" && entry.path().filename() != "report.json")
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    if (files.empty()) return misused(fmt::format("{}: contains no document of a benchmark", where.string()));
  } else {
    files.push_back(where);
  }
  std::vector<json> documents;
  for (const auto& file : files) {
    const auto text = runtime::read_input_file(file);
    if (!text) return tl::unexpected(Failure(text.error()));
    const auto content = json::parse(*text, nullptr, false);
    const bool has_all = content.is_object() && content.contains("benches") && content["benches"].is_array();
    for (const auto& part : has_all ? content["benches"] : json::array({content})) {
      auto document = parse_bench_document(part.dump(-1, ' ', false, json::error_handler_t::replace));
      if (!document)
        return misused(fmt::format("{}: not a document of a benchmark: {}", file.string(), document.error()));
      documents.push_back(std::move(*document));
    }
  }
  return documents;
}

Outcome<int> compare_runs(const Options& options) {
  if (options.names.size() != 2)
    return misused(
        "--compare takes two reports: report.json of one `bench --output`, then of another, or their folders");
  std::array<std::vector<json>, 2> runs;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto documents = read_bench_documents(options.names[i]);
    if (!documents) return tl::unexpected(documents.error());
    runs[i] = std::move(*documents);
  }
  const auto comparison = compare_benches(runs[0], runs[1]);
  print_out("{}", options.json ? json_text(comparison) : comparison_report(comparison));
  return 0;
}

Outcome<int> bench(const Options& options) {
  if (options.compare) return compare_runs(options);
  // A run of all programs is for a report, which must be complete within ten minutes.
  const auto extent = options.quick                            ? Extent::kQuick
                      : options.full || !options.names.empty() ? Extent::kFull
                                                               : Extent::kShort;
  const auto programs = find_programs(options.directory ? fs::path(*options.directory) : default_directory());
  if (!programs) return tl::unexpected(programs.error());
  const auto chosen = select(*programs, options.names);
  if (!chosen) return tl::unexpected(chosen.error());
  if (options.list) {
    for (const auto& program : *chosen) print_out("{}\n", program.filename().string());
    return 0;
  }
  std::vector<json> documents;
  std::string failures;
  for (std::size_t i = 0; i < chosen->size(); ++i) {
    const auto& program = (*chosen)[i];
    const auto name = program.filename().string();
    progress("{} of {}: {} ...", i + 1, chosen->size(), name);
    const auto begin = std::chrono::steady_clock::now();
    const auto output = output_of(program, extent);
    const auto document = output ? parse_bench_document(output->text) : tl::unexpected(output.error());
    if (!document) {
      failures += fmt::format("{}{} {}", failures.empty() ? "" : "; ", name, document.error());
      continue;
    }
    documents.push_back(*document);
    if (output->skipped) progress("  {} could not measure everything on this machine", name);
    progress("  {:.0f} s", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  if (options.json) {
    print_out("{}", json_text(json{{"benches", documents}}));
  } else if (!documents.empty()) {
    print_out("{}", bench_report(documents));
  }
  if (options.output && !documents.empty()) {
    if (auto written = write_output(*options.output, documents); !written) return tl::unexpected(written.error());
  }
  if (!failures.empty()) return failed(failures);
  return 0;
}

}  // namespace

Execute prepare_bench(Arguments& to) {
  auto options = std::make_shared<Options>();
  to.option("--dir", &options->directory, Value::folder(),
            "Folder of the programs (default: bench beside this program)");
  to.option("-o,--output", &options->output, Value::folder(),
            "Folder for documents, pictures and report: report.html contains everything, report.json all documents");
  to.flag("--quick", options->quick, "Run a tenth of the measurements, as a functional check");
  to.flag("--full", options->full, "Run all measurements of all programs: half an hour; default for named programs");
  to.flag("--compare", options->compare,
          "Compare the two named runs instead: report.json or its folder, the earlier run first");
  to.flag("--list", options->list, "List the programs instead of running them");
  to.flag("--json", options->json, "One JSON document on stdout");
  to.positional(&options->names, Value::text("NAME"), "Programs to run (default: all); with --compare two reports");
  return [options] { return bench(*options); };
}

}  // namespace driveline::cli
