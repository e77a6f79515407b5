#include "client/results_folder.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "client/files.h"
#include "client/folder_writer.h"
#include "client/preview.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/jobs/blobs.h"
#include "common/report/csv.h"
#include "common/report/heatmap.h"
#include "common/report/histogram.h"
#include "common/report/job_json.h"
#include "common/report/job_meshes.h"
#include "common/report/npy.h"
#include "common/report/variation_ply.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

/// Everything of a job that its files are made from.
struct Fetched {
  Job job;
  std::vector<JobMesh> meshes;
  std::vector<MeshAlignment> alignments;
  std::vector<MeshAlignment> poses;
  MetricMatrix matrix;               ///< Of the meshes that were not rejected, symmetrised.
  std::vector<std::string> persons;  ///< One per row of the matrix.
  TriangleMesh mean_shape;
  TriangleMesh variation_shape;
  std::vector<std::string> unmeasured;  ///< Meshes whose values of all others are NaN.
  VariationSummary variation;
  BaseChoice base_choice;  ///< Without candidates if the base was given.
};

std::vector<std::string> UnmeasuredMeshes(const MetricMatrix& directed) {
  std::vector<std::string> names;
  for (Eigen::Index row = 0; row < directed.values.rows(); ++row) {
    const auto unknown = directed.values.row(row).array().isNaN();
    const Eigen::Index off_diagonal = unknown.count() - (unknown(row) ? 1 : 0);
    if (off_diagonal == directed.values.cols() - 1) {
      names.push_back(directed.labels[static_cast<size_t>(row)]);
    }
  }
  return names;
}

absl::StatusOr<TriangleMesh> FetchMesh(Session& session, const Digest& blob) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, session.Blobs().Get(blob));
  return DecodeMeshBlob(bytes);
}

absl::StatusOr<std::vector<MeshAlignment>> FetchAlignments(Session& session,
                                                           const std::vector<Digest>& blobs) {
  std::vector<MeshAlignment> alignments;
  for (const Digest& blob : blobs) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, session.Blobs().Get(blob));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> some, DecodeAlignmentBlob(bytes));
    alignments.insert(alignments.end(), some.begin(), some.end());
  }
  return alignments;
}

absl::StatusOr<Fetched> Fetch(Session& session, const JobId& id, std::optional<Metric> metric) {
  Fetched fetched;
  COHORT_ASSIGN_OR_RETURN(fetched.job, session.GetJob(id));
  if (metric) {
    fetched.job.spec.metric = *metric;
  }
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, session.GetOutputs(id));
  COHORT_ASSIGN_OR_RETURN(fetched.meshes, session.ListJobMeshes(id));
  COHORT_ASSIGN_OR_RETURN(
      const RowMajorMatrix directed,
      session.GetMatrix(id, fetched.job.spec.metric, static_cast<int64_t>(fetched.meshes.size())));
  fetched.matrix = WithoutRejected(directed, fetched.meshes);
  fetched.unmeasured = UnmeasuredMeshes(fetched.matrix);
  if (fetched.job.spec.symmetrization != Symmetrization::kDirected) {
    fetched.matrix = Symmetrized(
        fetched.matrix,
        fetched.job.spec.symmetrization == Symmetrization::kMax ? PairRule::kMax : PairRule::kMean);
  }
  fetched.persons = PersonsOf(fetched.matrix.labels, fetched.meshes);
  COHORT_ASSIGN_OR_RETURN(fetched.alignments, FetchAlignments(session, outputs.alignments));
  COHORT_ASSIGN_OR_RETURN(fetched.poses, FetchAlignments(session, outputs.poses));
  COHORT_ASSIGN_OR_RETURN(fetched.mean_shape, FetchMesh(session, outputs.mean_shape));
  fetched.variation_shape = fetched.mean_shape;
  if (!outputs.variation_shape.empty()) {
    COHORT_ASSIGN_OR_RETURN(fetched.variation_shape, FetchMesh(session, outputs.variation_shape));
  }
  COHORT_ASSIGN_OR_RETURN(const std::string summary, session.Blobs().Get(outputs.summary));
  COHORT_ASSIGN_OR_RETURN(fetched.variation, DecodeSummaryBlob(summary));
  if (!outputs.base_choice.empty()) {
    COHORT_ASSIGN_OR_RETURN(const std::string choice, session.Blobs().Get(outputs.base_choice));
    COHORT_ASSIGN_OR_RETURN(fetched.base_choice, DecodeBaseBlob(choice));
  }
  return fetched;
}

std::string HostName() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return host.data();
}

/// The smallest of signed values is not the most similar.
bool HasNeighbours(const JobSpec& spec) {
  return spec.compare.sign == DistanceSign::kAbsolute;
}

/// What the files of this job do not say themselves.
std::vector<std::string> NotesOf(const Fetched& fetched) {
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
                         const Fetched& fetched,
                         const std::vector<std::vector<Neighbour>>& neighbours,
                         const std::string& unit) {
  const JobSpec& spec = fetched.job.spec;
  COHORT_RETURN_IF_ERROR(out.Write({"matrix.csv", "metric of every pair, with file names", unit},
                                   MatrixCsv(fetched.matrix, spec.metric)));
  if (HasNeighbours(spec)) {
    COHORT_RETURN_IF_ERROR(
        out.Write({"neighbours.csv", "the most similar meshes of each mesh", unit},
                  NeighboursCsv(fetched.matrix, neighbours, fetched.persons)));
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
                MatrixNpy(fetched.matrix.values)));
  return out.Write({"labels.txt", "file names of the rows of matrix.npy", ""},
                   LabelsText(fetched.matrix.labels));
}

absl::Status WritePictures(FolderWriter& out,
                           const Fetched& fetched,
                           const MatrixDescription& description) {
  const std::string unit = ValueUnit(description);
  COHORT_RETURN_IF_ERROR(out.Write({"heatmap.png", "the matrix as a picture", unit},
                                   HeatmapPng(fetched.matrix, description)));
  COHORT_RETURN_IF_ERROR(out.Write({"histogram.png", "distribution of the pairs", unit},
                                   HistogramPng(fetched.matrix, description, fetched.persons)));
  const JobSpec& spec = fetched.job.spec;
  const bool is_fidentis = spec.arithmetic == Arithmetic::kFidentis;
  const std::string mean = "the mean shape";
  const std::string stepped = "the aligned base mesh moved by one averaging step";
  COHORT_RETURN_IF_ERROR(out.Write(
      {"mean_shape.ply", is_fidentis && spec.method != Method::kAverage ? stepped : mean, "mm"},
      MeanShapePly(fetched.mean_shape)));
  return out.Write({"variation.ply",
                    (is_fidentis ? stepped : mean) +
                        " with, for each vertex, the metrics of its distances to all "
                        "meshes as scalars and the RMS as colour",
                    "mm"},
                   VariationPly(fetched.variation_shape, fetched.variation));
}

void CountPersons(const Fetched& fetched,
                  const std::vector<std::vector<Neighbour>>& neighbours,
                  ResultsDigest& digest) {
  for (size_t i = 0; i < fetched.persons.size(); ++i) {
    const std::string& person = fetched.persons[i];
    if (person.empty() || std::count(fetched.persons.begin(), fetched.persons.end(), person) < 2) {
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
                                           std::optional<Metric> metric,
                                           const std::filesystem::path& folder) {
  COHORT_ASSIGN_OR_RETURN(const Fetched fetched, Fetch(session, id, metric));
  COHORT_RETURN_IF_ERROR(PrepareFolder(folder));
  const JobSpec& spec = fetched.job.spec;
  const MatrixDescription description{.metric = spec.metric,
                                      .method = spec.method,
                                      .symmetrization = spec.symmetrization,
                                      .arithmetic = spec.arithmetic,
                                      .sign = spec.compare.sign};
  const auto neighbours = NearestNeighbours(fetched.matrix, spec.neighbours);
  FolderWriter out(folder);
  COHORT_RETURN_IF_ERROR(WriteTables(out, fetched, neighbours, ValueUnit(description)));
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
