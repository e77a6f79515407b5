// `cohort identify`: who of a job's meshes is nearest to a mesh that is not in it.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/fetched_matrix.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/job_source.h"
#include "client/output/exit_codes.h"
#include "client/probe.h"
#include "client/signatures.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/report/csv.h"
#include "common/report/decimal.h"
#include "common/report/job_meshes.h"
#include "common/report/pair_distribution.h"

namespace cohort {
namespace {

struct IdentifyFlags {
  JobSource source;
  std::vector<std::string> probes;
  std::string out;
  std::string metric;
  int top = 10;
  std::optional<int> shortlist;
};

/// Up to so many meshes all are compared with a probe; it takes seconds.
constexpr int64_t kComparedInAnyCase = 1000;
constexpr int64_t kShortestList = 100;
constexpr int64_t kListPerTop = 10;
/// Of the job's own meshes, to measure what a shortlist misses.
constexpr int64_t kRecallProbes = 200;

/// The meshes nearest by signature, which alone are compared.
struct Shortlist {
  Signatures signatures;
  int64_t length = 0;
  int64_t probes = 0;  ///< That `recall` was measured with; 0: it was not.
  double recall = std::numeric_limits<double>::quiet_NaN();
};

/// What all probes are held against.
struct Gallery {
  std::unique_ptr<JobFrame> frame;
  MeasureSpec measure;
  std::vector<std::string> persons;  ///< By job index; empty: unknown.
  /// Ascending values of the job's pairs of different people (of all pairs without persons), where
  /// the job has the metric.
  ScratchVector<double> different;
  std::optional<Shortlist> shortlist;  ///< Empty: all meshes are compared.
};

/// One probe and its nearest meshes.
struct Identified {
  Probe probe;
  std::vector<Match> matches;  ///< At most --top.
};

/// The job's values as a probe's are: one number a pair, of the active meshes.
absl::StatusOr<LargeMatrix> MatrixOf(Session& session, const Gallery& gallery) {
  const Job& job = gallery.frame->GetJob();
  COHORT_ASSIGN_OR_RETURN(LargeMatrix matrix, FetchMatrix(session, job.id, gallery.measure.metric,
                                                          gallery.frame->Meshes()));
  if (job.spec.symmetrization != Symmetrization::kDirected) {
    Symmetrize(job.spec.symmetrization == Symmetrization::kMax ? PairRule::kMax : PairRule::kMean,
               matrix.Values());
  }
  return matrix;
}

absl::StatusOr<std::optional<Shortlist>> MakeShortlist(const IdentifyFlags& flags,
                                                       const Gallery& gallery,
                                                       const std::optional<LargeMatrix>& exact) {
  const int64_t meshes = std::ssize(gallery.frame->Active());
  int64_t length = flags.shortlist.value_or(0);
  if (!flags.shortlist && meshes > kComparedInAnyCase) {
    length = std::max(kShortestList, kListPerTop * flags.top);
  }
  if (length == 0 || length >= meshes) {
    return std::nullopt;
  }
  if (length < flags.top) {
    return absl::InvalidArgumentError(absl::StrCat("--shortlist ", length,
                                                   " is shorter than --top ", flags.top,
                                                   ": expected 0 or at least that"));
  }
  absl::StatusOr<Signatures> signatures = Signatures::Load(*gallery.frame);
  if (absl::IsNotFound(signatures.status()) && !flags.shortlist) {
    return std::nullopt;  // Of an earlier build: all are compared, which takes longer.
  }
  COHORT_RETURN_IF_ERROR(signatures.status());
  Shortlist shortlist{.signatures = *std::move(signatures), .length = length};
  if (exact) {
    shortlist.probes = std::min(kRecallProbes, meshes);
    shortlist.recall =
        shortlist.signatures.Recall(exact->View().values, flags.top, length, shortlist.probes);
  }
  return shortlist;
}

absl::StatusOr<Gallery> OpenGallery(const IdentifyFlags& flags, const OpenedJob& opened) {
  Gallery gallery;
  COHORT_ASSIGN_OR_RETURN(gallery.frame,
                          JobFrame::Open(*opened.session, opened.Blobs(), opened.id));
  COHORT_RETURN_IF_ERROR(gallery.frame->CheckHasFrame());
  gallery.measure.metric = gallery.frame->GetJob().spec.metric;
  if (!flags.metric.empty()) {
    COHORT_ASSIGN_OR_RETURN(gallery.measure, ParseMeasure(flags.metric));
  }
  for (const JobMesh& mesh : gallery.frame->Meshes()) {
    const auto found = mesh.mesh.labels.find(std::string(kPersonLabel));
    gallery.persons.push_back(found == mesh.mesh.labels.end() ? "" : found->second);
  }
  std::optional<LargeMatrix> exact;
  if (gallery.measure.IsPlainMetric()) {
    COHORT_ASSIGN_OR_RETURN(exact, MatrixOf(*opened.session, gallery));
    const std::vector<std::string> persons = PersonsOf(exact->Labels(), gallery.frame->Meshes());
    gallery.different =
        CollectPairs(exact->View(), gallery.frame->GetJob().spec.symmetrization, persons).different;
  }
  COHORT_ASSIGN_OR_RETURN(gallery.shortlist, MakeShortlist(flags, gallery, exact));
  return gallery;
}

/// Share of the job's pairs of different people that are at most as far apart: how surprising such
/// a value is between two people. NaN if not known.
double ShareAsNear(const Gallery& gallery, double value) {
  if (gallery.different.empty() || std::isnan(value)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto end = std::upper_bound(gallery.different.begin(), gallery.different.end(), value);
  return static_cast<double>(end - gallery.different.begin()) /
         static_cast<double>(gallery.different.size());
}

const std::string& NameOf(const Gallery& gallery, const Match& match) {
  return gallery.frame->Meshes()[static_cast<size_t>(match.mesh)].mesh.name;
}

nlohmann::json Number(double value) {
  return std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
}

/// null: all meshes were compared.
nlohmann::json ShortlistJson(const Gallery& gallery) {
  if (!gallery.shortlist) {
    return nullptr;
  }
  return {{"length", gallery.shortlist->length},
          {"recall", Number(gallery.shortlist->recall)},
          {"recall_probes", gallery.shortlist->probes}};
}

/// "compared with the 100 of 5000 meshes that are nearest by signature; ...", or nothing.
std::string ShortlistText(const Gallery& gallery, int top) {
  if (!gallery.shortlist) {
    return "";
  }
  const Shortlist& shortlist = *gallery.shortlist;
  std::string text =
      absl::StrCat("compared with the ", shortlist.length, " of ", gallery.frame->Active().size(),
                   " meshes that are nearest by signature; ");
  if (shortlist.probes == 0) {
    return text + "what they miss is not known for " + gallery.measure.Name() + "\n";
  }
  return text + absl::StrCat("such a list holds ", ReadableDecimal(shortlist.recall * 100, 3),
                             " % of the ", top, " nearest (measured on ", shortlist.probes,
                             " of the job's own meshes)\n");
}

nlohmann::json ToJson(const Gallery& gallery, const Identified& identified) {
  const Alignment& alignment = identified.probe.alignment;
  nlohmann::json matches = nlohmann::json::array();
  for (size_t i = 0; i < identified.matches.size(); ++i) {
    const Match& match = identified.matches[i];
    matches.push_back({{"rank", i + 1},
                       {"mesh", NameOf(gallery, match)},
                       {"person", gallery.persons[static_cast<size_t>(match.mesh)]},
                       {"value", Number(match.value)},
                       {"from_probe", Number(match.from_probe)},
                       {"to_probe", Number(match.to_probe)},
                       {"different_pairs_as_near", Number(ShareAsNear(gallery, match.value))}});
  }
  return {{"probe", identified.probe.name},
          {"alignment",
           {{"converged", alignment.converged},
            {"iterations", alignment.iterations},
            {"rms_residual", alignment.rms_residual},
            {"overlap", alignment.overlap},
            {"scale", alignment.T_target_source.scale}}},
          {"warnings", identified.probe.health.warnings},
          {"matches", matches}};
}

std::string ToText(const Gallery& gallery, const Identified& identified) {
  const Alignment& alignment = identified.probe.alignment;
  std::string text = absl::StrFormat(
      "%s: %s\n", identified.probe.name,
      gallery.frame->GetJob().spec.method == Method::kNone
          ? "not aligned, as the job (method none)"
          : absl::StrCat(alignment.converged ? "aligned" : "NOT CONVERGED", " in ",
                         alignment.iterations, " iterations, residual ",
                         ReadableDecimal(alignment.rms_residual, 3), " mm, overlap ",
                         ReadableDecimal(alignment.overlap * 100, 3), " %"));
  for (const std::string& warning : identified.probe.health.warnings) {
    text += "  note: " + warning + "\n";
  }
  const bool has_persons = std::any_of(gallery.persons.begin(), gallery.persons.end(),
                                       [](const std::string& person) { return !person.empty(); });
  size_t width = 4;
  for (const Match& match : identified.matches) {
    width = std::max(width, NameOf(gallery, match).size());
  }
  text += absl::StrFormat("  rank  %-*s  %12s  %s%s\n", static_cast<int>(width), "mesh",
                          gallery.measure.Name() + " (mm)",
                          gallery.different.empty() ? "" : "different people as near",
                          has_persons ? "  person" : "");
  for (size_t i = 0; i < identified.matches.size(); ++i) {
    const Match& match = identified.matches[i];
    const double share = ShareAsNear(gallery, match.value);
    text += absl::StrFormat(
        "  %4d  %-*s  %12s  %s%s\n", i + 1, static_cast<int>(width), NameOf(gallery, match),
        ReadableDecimal(match.value, 4),
        gallery.different.empty() ? ""
                                  : absl::StrFormat("%22s %%", ReadableDecimal(share * 100, 3)),
        has_persons ? "  " + gallery.persons[static_cast<size_t>(match.mesh)] : "");
  }
  return text;
}

std::string ToCsv(const Gallery& gallery, const std::vector<Identified>& all) {
  std::string csv =
      CsvRow(std::array<std::string, 8>{"probe", "rank", "mesh", "person", "value", "from_probe",
                                        "to_probe", "different_pairs_as_near"});
  for (const Identified& identified : all) {
    for (size_t i = 0; i < identified.matches.size(); ++i) {
      const Match& match = identified.matches[i];
      const std::string& person = gallery.persons[static_cast<size_t>(match.mesh)];
      csv += CsvRow(std::array<std::string, 8>{
          identified.probe.name, std::to_string(i + 1), NameOf(gallery, match),
          person.empty() ? "NA" : person, ShortestDecimal(match.value),
          ShortestDecimal(match.from_probe), ShortestDecimal(match.to_probe),
          ShortestDecimal(ShareAsNear(gallery, match.value))});
    }
  }
  return csv;
}

absl::StatusOr<int> RunIdentify(const IdentifyFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const OpenedJob opened, flags.source.Open());
  COHORT_ASSIGN_OR_RETURN(const Gallery gallery, OpenGallery(flags, opened));
  const JobSpec& spec = gallery.frame->GetJob().spec;
  if (!flags.source.server.json) {
    std::cout << ShortlistText(gallery, flags.top);
  }
  ThreadPool threads(LocalThreads());
  std::vector<Identified> all;
  nlohmann::json json = nlohmann::json::array();
  for (const std::string& file : flags.probes) {
    COHORT_ASSIGN_OR_RETURN(
        Probe probe,
        AlignProbe(*gallery.frame, file, {.compare = spec.compare, .sign = gallery.measure.sign}));
    std::vector<int32_t> candidates = gallery.frame->Active();
    if (gallery.shortlist) {
      COHORT_ASSIGN_OR_RETURN(candidates, gallery.shortlist->signatures.Nearest(
                                              *gallery.frame, probe, gallery.shortlist->length));
    }
    COHORT_ASSIGN_OR_RETURN(std::vector<Match> matches,
                            RankMeshes(*gallery.frame, probe, candidates, gallery.measure,
                                       spec.symmetrization, threads));
    matches.resize(std::min(matches.size(), static_cast<size_t>(flags.top)));
    all.push_back({std::move(probe), std::move(matches)});
    json.push_back(ToJson(gallery, all.back()));
    if (!flags.source.server.json) {
      std::cout << ToText(gallery, all.back()) << std::flush;
    }
  }
  json = {{"job", opened.id.value},
          {"metric", gallery.measure.Name()},
          {"unit", gallery.measure.metric == Metric::kVariance ? "mm²" : "mm"},
          {"meshes", gallery.frame->Active().size()},
          {"shortlist", ShortlistJson(gallery)},
          {"probes", std::move(json)}};
  if (flags.source.server.json) {
    std::cout << json.dump(2) << "\n";
  }
  if (!flags.out.empty()) {
    COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
    FolderWriter out(flags.out);
    COHORT_RETURN_IF_ERROR(
        out.Write({"identified.csv", "nearest meshes of each probe", "mm"}, ToCsv(gallery, all)));
    COHORT_RETURN_IF_ERROR(
        out.Write({"identify.json", "the same with the alignments", "mm"}, json.dump(2) + "\n"));
  }
  return kExitOk;
}

}  // namespace

void AddIdentifyCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "identify", "align mesh files to a job's frame and rank its meshes by distance");
  const auto flags = std::make_shared<IdentifyFlags>();
  flags->source.AddTo(*command);
  command->add_option("probe", flags->probes, "mesh files")->required();
  command->add_option("--top", flags->top, "nearest meshes listed")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--metric", flags->metric,
                      "rms, mean, geometric-mean, min, max, variance, or a percentile: p95; else "
                      "the job's");
  command
      ->add_option("--shortlist", flags->shortlist,
                   "meshes that are compared exactly, the nearest by signature (where they lie "
                   "at 512 vertices of the reference); 0: all [all up to 1000 meshes, then 100 "
                   "or 10 x top]")
      ->check(CLI::Range(0, 100'000'000));
  command->add_option("--out", flags->out, "folder for identified.csv and identify.json");
  command->callback([flags, &action] { action = [flags] { return RunIdentify(*flags); }; });
  command->footer(
      "Nothing of the job changes. \"Different people as near\" is the share of the job's pairs "
      "of\n"
      "different people (without persons: of all its pairs) that are at most as far apart.\n"
      "Example: cohort identify j-000001 unknown.ply --top 5");
}

}  // namespace cohort
