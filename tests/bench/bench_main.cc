#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <benchmark/benchmark.h>

#include "tests/bench/bench.h"

namespace cohort {
namespace {

constexpr int kExitShort = 1;
constexpr int kExitUsage = 2;
constexpr int kExitFailed = 3;

/// One line for each group on stderr, so that a person sees that it goes on.
class ProgressReporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& /*context*/) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      failed_ = failed_ || run.error_occurred;
      std::cerr << "bench: " << run.run_name.function_name
                << (run.error_occurred ? " FAILED: " + run.error_message : " done") << std::endl;
    }
  }
  [[nodiscard]] bool Failed() const { return failed_; }

 private:
  bool failed_ = false;
};

struct Arguments {
  BenchOptions options;
  bool check = false;
  std::string table_path;  ///< Empty: standard output only.
  std::string unknown;     ///< The first argument that means nothing.
};

/// The value of "--name=value", or null.
const char* ValueOf(const char* argument, std::string_view name) {
  const std::string_view given = argument;
  if (given.size() > name.size() && given.substr(0, name.size()) == name &&
      given[name.size()] == '=') {
    return argument + name.size() + 1;
  }
  return nullptr;
}

Arguments Parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0) {
      arguments.options.depth = BenchOptions::Depth::kQuick;
    } else if (std::strcmp(argv[i], "--check") == 0) {
      arguments.check = true;
    } else if (const char* data = ValueOf(argv[i], "--data")) {
      arguments.options.data_folder = data;
    } else if (const char* shared = ValueOf(argv[i], "--shared")) {
      arguments.options.shared_data = shared;
    } else if (const char* program = ValueOf(argv[i], "--cohort")) {
      arguments.options.cohort_program = program;
    } else if (const char* table = ValueOf(argv[i], "--table")) {
      arguments.table_path = table;
    } else if (arguments.unknown.empty()) {
      arguments.unknown = argv[i];
    }
  }
  return arguments;
}

int Run(const Arguments& arguments) {
  Bench bench(arguments.options);
  RegisterNearest(bench);
  RegisterUnlike(bench);
  RegisterIndex(bench);
  RegisterPairs(bench);
  RegisterSurface(bench);
  RegisterIcpPass(bench);
  RegisterAlignment(bench);
  RegisterService(bench);
  ProgressReporter progress;
  benchmark::RunSpecifiedBenchmarks(&progress);
  const std::string table = bench.figures.Markdown();
  std::cout << table;
  if (!arguments.table_path.empty() && !(std::ofstream(arguments.table_path) << table)) {
    std::cerr << "bench: cannot write " << arguments.table_path << "\n";
    return kExitFailed;
  }
  if (progress.Failed() || bench.figures.IsEmpty()) {
    std::cerr << "bench: a group failed, or none was asked for\n";
    return kExitFailed;
  }
  const std::vector<std::string> shortfalls = bench.figures.Shortfalls();
  for (const std::string& line : shortfalls) {
    std::cout << "falls short: " << line << "\n";
  }
  return arguments.check && !shortfalls.empty() ? kExitShort : 0;
}

}  // namespace
}  // namespace cohort

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const cohort::Arguments arguments = cohort::Parse(argc, argv);
  if (!arguments.unknown.empty()) {
    std::cerr << "bench: unknown argument " << arguments.unknown << "\n"
              << "usage: cohort-bench [--quick] [--check] [--data=FOLDER] [--shared=FOLDER] "
                 "[--cohort=PROGRAM] [--table=FILE] [--benchmark_filter=REGEX] "
                 "[--benchmark_out=FILE.json]\n";
    return cohort::kExitUsage;
  }
  return cohort::Run(arguments);
}
