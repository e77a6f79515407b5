#pragma once

#include <functional>
#include <string>
#include <utility>

#include <absl/status/status.h>
#include <benchmark/benchmark.h>

#include "tests/bench/contest.h"
#include "tests/bench/face_sets.h"
#include "tests/bench/figures.h"

namespace cohort {

struct BenchOptions {
  enum class Depth { kFull, kQuick };
  Depth depth = Depth::kFull;
  std::string data_folder = "bench-data";  ///< Meshes made by run.sh; prepared ones are kept there.
  std::string shared_data;     ///< ../shared/data; empty or missing: what needs it is left out.
  std::string cohort_program;  ///< bin/cohort; empty: no row for the service.

  [[nodiscard]] bool IsQuick() const { return depth == Depth::kQuick; }
};

/// A whole run: what the benchmarks share. Not thread-safe.
struct Bench {
  explicit Bench(BenchOptions given)
      : options(std::move(given)),
        faces(options.data_folder),
        diverse_faces(options.data_folder + "/diverse"),
        template_face(options.data_folder + "/template", 0) {}

  BenchOptions options;
  FaceSets faces;          ///< People about 2 mm apart (RMS), as in performance.md section 0.
  FaceSets diverse_faces;  ///< People about 3 mm apart: the generator's full spread.
  FaceSets template_face;  ///< The average person, one.
  FigureTable figures;
};

/// Measures one group of figures: fills a Contest, runs it on `state`, adds to bench.figures.
using Measure = std::function<absl::Status(Bench& bench, benchmark::State& state)>;

/// Registers a group with Google Benchmark: one iteration is one round of its contest.
/// @param bench  must live until all benchmarks have run.
void Register(Bench& bench, const std::string& name, int rounds, Measure measure);

void RegisterNearest(Bench& bench);    ///< Vertex to vertex, and how exact it is.
void RegisterUnlike(Bench& bench);     ///< The same between unlike shapes.
void RegisterIndex(Bench& bench);      ///< Building the index.
void RegisterPairs(Bench& bench);      ///< Metrics of a pair; many meshes in tiles.
void RegisterSurface(Bench& bench);    ///< Vertex to surface.
void RegisterIcpPass(Bench& bench);    ///< One pass of ICP near convergence.
void RegisterAlignment(Bench& bench);  ///< Whole alignments.
void RegisterService(Bench& bench);    ///< A whole job.

}  // namespace cohort
