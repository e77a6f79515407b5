#include "client/results_folder.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <thread>

#include "client/fetched_job.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/matrix_writer.h"
#include "client/preview.h"
#include "client/report_file.h"
#include "common/analysis/clustering.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/base/version.h"
#include "common/report/csv.h"
#include "common/report/heatmap.h"
#include "common/report/histogram.h"
#include "common/report/job_json.h"
#include "common/report/job_meshes.h"
#include "common/report/npy.h"
#include "common/report/render/variation_picture.h"
#include "common/report/variation_ply.h"

namespace cohort {
namespace {

std::string HostName() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return host.data();
}

/// The smallest of signed values is not the most similar.
bool HasNeighbours(const JobSpec& spec) {
  return spec.compare.sign == DistanceSign::kAbsolute;
}

bool HasTree(const FetchedJob& fetched) {
  return std::ssize(fetched.matrix.Labels()) <= kMostClustered;
}

/// What the files of this job do not say themselves.
std::vector<std::string> NotesOf(const FetchedJob& fetched) {
  constexpr size_t kNamed = 3;
  const JobSpec& spec = fetched.job.spec;
  std::vector<std::string> notes;
  if (spec.arithmetic == Arithmetic::kFidentis) {
    notes.emplace_back(
        "preset fidentis: the numbers of FIDENTIS Analyst of 2016, defects included, for "
        "comparison "
        "with old studies; transforms.csv and the residuals in meshes.csv are ours, of its poses");
  }
  if (!HasNeighbours(spec)) {
    notes.emplace_back(
        "neighbours.csv is left out: of signed distances the smallest is not the most similar");
  }
  if (!HasTree(fetched)) {
    notes.push_back("dendrogram.newick is left out: it is made of up to " +
                    std::to_string(kMostClustered) + " meshes");
  }
  std::string names;
  for (size_t i = 0; i < std::min(kNamed, fetched.unmeasured.size()); ++i) {
    names += (i == 0 ? "" : ", ") + fetched.unmeasured[i];
  }
  if (!fetched.unmeasured.empty()) {
    const size_t more = fetched.unmeasured.size() - std::min(kNamed, fetched.unmeasured.size());
    notes.push_back("no value (NA) in the rows of " + names +
                    (more > 0 ? " and " + std::to_string(more) + " more" : "") +
                    (spec.arithmetic == Arithmetic::kFidentis
                         ? ": as in the predecessor, where a vertex has no normal (see warnings in "
                           "meshes.csv), and for geometric means of negative distances"
                         : ""));
  }
  return notes;
}

absl::Status WriteTables(FolderWriter& out,
                         const FetchedJob& fetched,
                         const std::vector<std::vector<Neighbour>>& neighbours,
                         const std::string& unit,
                         Executor& executor) {
  const JobSpec& spec = fetched.job.spec;
  const MatrixView matrix = fetched.matrix.View();
  COHORT_RETURN_IF_ERROR(out.Write(
      {"matrix.csv", "metric of every pair, with file names", unit}, [&](const auto& file) {
        return WriteMatrixCsv(file, matrix, MetricName(spec.metric), executor);
      }));
  if (HasNeighbours(spec)) {
    COHORT_RETURN_IF_ERROR(
        out.Write({"neighbours.csv", "the most similar meshes of each mesh", unit},
                  NeighboursCsv(matrix, neighbours, fetched.persons)));
  } else {
    out.LeaveOut("neighbours.csv");
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"meshes.csv", "each file: health, labels, and how well it was aligned", "mm"},
                MeshesCsv(fetched.meshes, fetched.alignments, fetched.poses)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"transforms.csv", "similarity of each mesh to the reference", "mm"},
                TransformsCsv(fetched.meshes, fetched.alignments)));
  if (!fetched.base_choice.candidates.empty()) {
    COHORT_RETURN_IF_ERROR(out.Write(
        {"base_choice.csv", "mean distance of each candidate for the base to the others", "mm"},
        BaseChoiceCsv(fetched.meshes, fetched.base_choice)));
  } else {
    out.LeaveOut("base_choice.csv");
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"matrix.npy", "matrix.csv for NumPy, row = source, column = target", unit},
                [&](const auto& file) { return WriteMatrixNpy(file, matrix); }));
  return out.Write({"labels.txt", "file names of the rows of matrix.npy", ""},
                   LabelsText(matrix.labels));
}

absl::Status WritePictures(FolderWriter& out,
                           const FetchedJob& fetched,
                           const MatrixDescription& description) {
  const std::string unit = ValueUnit(description);
  COHORT_RETURN_IF_ERROR(out.Write({"heatmap.png", "the matrix as a picture", unit},
                                   HeatmapPng(fetched.matrix.View(), description)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"histogram.png", "distribution of the pairs", unit},
                HistogramPng(fetched.matrix.View(), description, fetched.persons)));
  const JobSpec& spec = fetched.job.spec;
  const bool is_fidentis = spec.arithmetic == Arithmetic::kFidentis;
  const std::string mean = "the mean shape";
  const std::string stepped = "the aligned base mesh moved by one averaging step";
  COHORT_RETURN_IF_ERROR(out.Write(
      {"mean_shape.ply", is_fidentis && spec.method != Method::kAverage ? stepped : mean, "mm"},
      MeanShapePly(fetched.mean_shape)));
  const std::string values = (is_fidentis ? stepped : mean) +
                             " with, for each vertex, the metrics of its distances to all "
                             "meshes as scalars";
  COHORT_RETURN_IF_ERROR(out.Write({"variation.ply", values + " and the RMS as colour", "mm"},
                                   VariationPly(fetched.variation_shape, fetched.variation)));
  COHORT_RETURN_IF_ERROR(out.Write({"variation.vtk", values + " (legacy VTK)", "mm"},
                                   VariationVtk(fetched.variation_shape, fetched.variation)));
  return out.Write({"variation.png", "the RMS on the shape from three views", "mm"},
                   VariationPng(fetched.variation_shape, fetched.variation));
}

/// What a report is made from besides the job.
struct ReportParts {
  const MatrixDescription& description;
  const std::vector<std::vector<Neighbour>>& neighbours;
  const std::vector<std::string>& notes;
};

/// What takes threads: the report and the aligned meshes.
absl::Status WriteExtras(Session& session,
                         const FetchedJob& fetched,
                         const ReportParts& parts,
                         const ResultsOptions& options,
                         Executor& threads,
                         FolderWriter& out) {
  if (options.report == ResultsOptions::Report::kWrite) {
    COHORT_RETURN_IF_ERROR(out.Write(
        {"report.html", "all of it for people: open it in a browser", ""},
        MakeReport(session, fetched, parts.description, parts.neighbours, parts.notes, threads)));
  } else {
    out.LeaveOut("report.html");
  }
  if (!options.aligned_meshes) return absl::OkStatus();
  COHORT_ASSIGN_OR_RETURN(const int64_t written,
                          WriteAlignedMeshes(session, fetched, *options.aligned_meshes,
                                             out.Folder() / kAlignedFolder, threads));
  out.Note({std::string(kAlignedFolder) + "/",
            Counted(written, "mesh", "meshes") + " in the frame of the job", "mm"});
  return absl::OkStatus();
}

/// The tree of average linkage; nothing where the values are no distances or some are missing, or
/// for more meshes than can be clustered.
absl::Status WriteTree(FolderWriter& out, const FetchedJob& fetched, const std::string& unit) {
  const JobSpec& spec = fetched.job.spec;
  if (!HasNeighbours(spec) || !HasTree(fetched)) {
    out.LeaveOut("dendrogram.newick");
    return absl::OkStatus();
  }
  absl::StatusOr<Dendrogram> tree;
  if (spec.symmetrization == Symmetrization::kDirected) {
    LargeMatrix undirected(fetched.matrix.View());
    Symmetrize(PairRule::kMean, undirected.Values());
    tree = ClusterMeshes(undirected.View(), Linkage::kAverage);
  } else {
    tree = ClusterMeshes(fetched.matrix.View(), Linkage::kAverage);
  }
  if (!tree.ok()) {
    out.LeaveOut("dendrogram.newick");
    return absl::OkStatus();
  }
  return out.Write({"dendrogram.newick", "clusters by average linkage, as a tree", unit},
                   NewickText(*tree, fetched.matrix.Labels()));
}

void CountPersons(const FetchedJob& fetched,
                  const std::vector<std::vector<Neighbour>>& neighbours,
                  ResultsDigest& digest) {
  std::map<std::string_view, int64_t> meshes_of;
  for (const std::string& person : fetched.persons) {
    ++meshes_of[person];
  }
  for (size_t i = 0; i < fetched.persons.size(); ++i) {
    const std::string& person = fetched.persons[i];
    if (person.empty() || meshes_of[person] < 2) {
      continue;
    }
    ++digest.with_same_person;
    if (!neighbours[i].empty() &&
        fetched.persons[static_cast<size_t>(neighbours[i][0].column)] == person) {
      ++digest.nearest_same_person;
    }
  }
}

}  // namespace

absl::StatusOr<ResultsDigest> WriteResults(Session& session,
                                           const JobId& id,
                                           const ResultsOptions& options,
                                           const std::filesystem::path& folder) {
  COHORT_ASSIGN_OR_RETURN(const FetchedJob fetched, FetchJob(session, id, options.metric));
  COHORT_RETURN_IF_ERROR(PrepareFolder(folder));
  const JobSpec& spec = fetched.job.spec;
  const MatrixDescription description{.metric = spec.metric,
                                      .method = spec.method,
                                      .symmetrization = spec.symmetrization,
                                      .arithmetic = spec.arithmetic,
                                      .sign = spec.compare.sign};
  const auto neighbours = NearestNeighbours(fetched.matrix.View(), spec.neighbours);
  ThreadPool threads(std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 16));
  FolderWriter out(folder);
  COHORT_RETURN_IF_ERROR(WriteTables(out, fetched, neighbours, ValueUnit(description), threads));
  COHORT_RETURN_IF_ERROR(WriteTree(out, fetched, ValueUnit(description)));
  COHORT_RETURN_IF_ERROR(WritePictures(out, fetched, description));
  if (spec.preview) {
    COHORT_RETURN_IF_ERROR(WritePreview(session, fetched.job, folder).status());
    out.Note({"preview_matrix.csv", "RMS over corresponding points, not the exact matrix", "mm"});
    out.Note({"preview_heatmap.png", "preview_matrix.csv as a picture", "mm"});
  } else {
    out.LeaveOut("preview_matrix.csv");
    out.LeaveOut("preview_heatmap.png");
  }

  ResultsDigest digest;
  digest.job = fetched.job;
  digest.meshes = fetched.meshes;
  digest.notes = NotesOf(fetched);
  COHORT_RETURN_IF_ERROR(WriteExtras(session, fetched, {description, neighbours, digest.notes},
                                     options, threads, out));
  if (HasNeighbours(spec)) {
    CountPersons(fetched, neighbours, digest);
  }
  for (const ResultFile& file : out.Files()) {
    digest.files.push_back(file.name);
  }
  // Last, so that a folder with a job.json is a whole one.
  COHORT_RETURN_IF_ERROR(
      out.Write({"job.json", "parameters, inputs, versions, counters, times", ""},
                JobJson({.job = fetched.job,
                         .meshes = fetched.meshes,
                         .files = out.Files(),
                         .notes = digest.notes,
                         .software_version = "cohort " + std::string(BuildVersion()),
                         .host = HostName()})));
  digest.files.push_back("job.json");
  return digest;
}

}  // namespace cohort
