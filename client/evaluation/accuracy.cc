#include <algorithm>
#include <cmath>
#include <numbers>

#include <absl/strings/str_cat.h>
#include <Eigen/Geometry>

#include "client/evaluation/evaluation.h"
#include "client/evaluation/shapes.h"
#include "client/files.h"
#include "client/job_frame.h"
#include "common/analysis/verification.h"
#include "common/base/status_macros.h"
#include "common/geometry/mesh/boundary.h"
#include "common/geometry/registration/coarse_pose.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/pairs/canonical_mesh.h"
#include "common/pairs/distance_finder.h"
#include "common/report/decimal.h"

namespace cohort {
namespace {

constexpr size_t kSampledMeshes = 5;

double RootMeanSquare(const Eigen::Matrix3Xd& difference) {
  return std::sqrt(difference.squaredNorm() / static_cast<double>(difference.cols()));
}

/// Figures 2.4 and 3.3: a copy that was turned, moved and enlarged is found again.
absl::Status AddRecovery(Evaluation& evaluation) {
  const MeshFile& file = evaluation.Middle().files.front();
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, ReadWholeFile(file.path));
  COHORT_ASSIGN_OR_RETURN(const CanonicalMesh canonical,
                          MakeCanonical(bytes, file.mesh.name, JobSpec().position_bits));
  const TriangleMesh& mesh = canonical.mesh;
  Similarity T_moved_mesh;
  T_moved_mesh.scale = 1.07;
  T_moved_mesh.rotation =
      Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  T_moved_mesh.translation = {30, -12, 55};
  const TriangleMesh moved{.vertices = T_moved_mesh.Apply(mesh.vertices), .faces = mesh.faces};
  COHORT_ASSIGN_OR_RETURN(const CoarsePose pose, FindCoarsePose(mesh, moved));
  PacketSearch search;
  COHORT_ASSIGN_OR_RETURN(const Alignment found,
                          AlignByIcp(IcpMesh(mesh.vertices, BoundaryVertices(mesh)),
                                     IcpMesh(moved.vertices, BoundaryVertices(moved)),
                                     pose.T_target_source, {}, search));
  const Eigen::AngleAxisd error(
      Eigen::Matrix3d(found.T_target_source.rotation * T_moved_mesh.rotation.transpose()));
  const double degrees = std::abs(error.angle()) * 180 / std::numbers::pi;
  const double scale = std::abs(found.T_target_source.scale / T_moved_mesh.scale - 1);
  evaluation.findings.Check(
      "fig. 2.4, 3.3", PropertyClass::kOrdinal,
      "a turned, moved and enlarged copy is found again: rotation to 0.1 degrees, scale to 0.001",
      "alignment and scaling visibly help",
      absl::StrCat(degrees, " degrees, ", scale, " of the scale, RMS ",
                   RootMeanSquare(found.T_target_source.Apply(mesh.vertices) - moved.vertices),
                   " mm"),
      degrees < 0.1 && scale < 1e-3);
  return absl::OkStatus();
}

/// Figures 3.6 and 3.7: distances between different scans are hardly ever exactly 0.
absl::Status AddZeros(Evaluation& evaluation, Lab& lab) {
  const Experiment& run = evaluation.densities.front().runs[kAverage];
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(lab.GetSession(), lab.GetSession().Blobs(), run.job.id));
  std::vector<FramedMesh> meshes;
  for (size_t i = 0; i < std::min(kSampledMeshes, frame->Active().size()); ++i) {
    COHORT_ASSIGN_OR_RETURN(FramedMesh mesh, frame->Load(frame->Active()[i], {}));
    meshes.push_back(std::move(mesh));
  }
  DistanceFinder finder({}, DistanceSign::kAbsolute);
  int64_t zeros = 0;
  int64_t all = 0;
  for (size_t i = 0; i < meshes.size(); ++i) {
    for (size_t j = 0; j < meshes.size(); ++j) {
      if (i == j) continue;
      const PairDistances& found = finder.Find(meshes[i].placed, meshes[j].placed);
      zeros += std::count(found.distances.begin(), found.distances.end(), 0.0F);
      all += std::ssize(found.distances);
    }
  }
  evaluation.findings.Check("fig. 3.6-3.7", PropertyClass::kOrdinal,
                            "under 1 % of the distances between different scans are 0", "few",
                            absl::StrCat(zeros, " of ", all), 100 * zeros < all);
  return absl::OkStatus();
}

/// What every matrix of absolute distances must be.
absl::Status AddOrder(Evaluation& evaluation, Lab& lab) {
  const Experiment& run = evaluation.Middle().runs[kAverage];
  std::array<MetricMatrix, kMetricCount> matrices;
  for (const Metric metric : kAllMetrics) {
    COHORT_ASSIGN_OR_RETURN(matrices[static_cast<size_t>(metric)], lab.Matrix(run, metric));
  }
  const auto values = [&](Metric metric) -> const RowMajorMatrix& {
    return matrices[static_cast<size_t>(metric)].values;
  };
  constexpr double kRounding = 1e-12;  // Of the mean of two directions.
  const auto at_most = [&](Metric a, Metric b) {
    return (values(a).array() <= values(b).array() * (1 + kRounding)).all();
  };
  const bool ordered =
      at_most(Metric::kMin, Metric::kGeometricMean) &&
      at_most(Metric::kGeometricMean, Metric::kMean) && at_most(Metric::kMean, Metric::kRms) &&
      at_most(Metric::kRms, Metric::kMax) && at_most(Metric::kPercentile75, Metric::kMax);
  const RowMajorMatrix& rms = values(Metric::kRms);
  evaluation.findings.Check("summary", PropertyClass::kFormula,
                            "min <= geometric mean <= mean <= RMS <= max and P75 <= max", "so",
                            ordered ? "in every cell" : "not in every cell", ordered);
  evaluation.findings.Check(
      "summary", PropertyClass::kFormula, "the matrix is symmetric with a zero diagonal", "so",
      absl::StrCat("largest difference ", (rms - rms.transpose()).cwiseAbs().maxCoeff()),
      rms == rms.transpose() && rms.diagonal().isZero(0));
  return absl::OkStatus();
}

/// How far the alignments of a job are from where ICP, with the same rule of scale, ends if it is
/// not stopped: RMS over the vertices of all meshes, mm.
absl::StatusOr<double> DistanceToFixedPoint(Evaluation& evaluation,
                                            Lab& lab,
                                            const Experiment& run) {
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(lab.GetSession(), lab.GetSession().Blobs(), run.job.id));
  COHORT_ASSIGN_OR_RETURN(const TriangleMesh reference, frame->LoadReference());
  const IcpMesh target(reference.vertices, BoundaryVertices(reference));
  IcpOptions options = run.job.spec.icp;
  options.acceleration = Acceleration::kAnderson;
  options.rigid_first = false;
  options.max_iterations = 1000;
  options.tolerance = 1e-9;
  const std::vector<int32_t>& active = frame->Active();
  std::vector<double> squares(active.size());
  std::vector<absl::Status> statuses(active.size());
  evaluation.executor.ParallelFor(std::ssize(active), [&](int64_t i) {
    const auto place = static_cast<size_t>(i);
    const absl::StatusOr<FramedMesh> mesh = frame->Load(active[place], {});
    statuses[place] = mesh.status();
    if (!mesh.ok()) return;
    PacketSearch search;
    const absl::StatusOr<Alignment> end =
        AlignByIcp(IcpMesh(mesh->mesh.vertices, BoundaryVertices(mesh->mesh)), target,
                   mesh->T_frame_mesh, options, search);
    statuses[place] = end.status();
    if (!end.ok()) return;
    const double distance = RootMeanSquare(end->T_target_source.Apply(mesh->mesh.vertices) -
                                           mesh->T_frame_mesh.Apply(mesh->mesh.vertices));
    squares[place] = distance * distance;
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

/// The thesis's 10 iterations a round against our default, which converges.
absl::Status AddConverged(Evaluation& evaluation, Lab& lab) {
  const Density& density = evaluation.Middle();
  COHORT_ASSIGN_OR_RETURN(const Experiment converged,
                          lab.Run(density.set, JobSpec{}, Timing::kAnyTime));
  EvaluationTable table{
      "converged",
      "To Average with the thesis's parameters and with the default "
      "(until 1e-6 mm), " +
          density.name,
      {"parameters", "from the fixed point (mm, RMS)", "seconds", "rank-1", "EER (%)", "d'"},
      {},
      ""};
  std::vector<double> distances;
  for (const auto& [name, run] :
       {std::pair{"thesis: 10 iterations, 0.05 mm", &density.runs[kAverage]},
        std::pair{"default", &converged}}) {
    COHORT_ASSIGN_OR_RETURN(const double distance, DistanceToFixedPoint(evaluation, lab, *run));
    distances.push_back(distance);
    std::vector<std::string> row = {
        name, FixedDecimal(distance, 5), FixedDecimal(run->seconds, 2), "", "", ""};
    if (evaluation.has_persons) {
      const Identities identities = evaluation.IdentitiesOf(run->rms);
      COHORT_ASSIGN_OR_RETURN(const Identification found,
                              IdentifyPersons(run->rms, identities, Gallery::kAllOthers));
      COHORT_ASSIGN_OR_RETURN(const VerificationScores scores,
                              CollectScores(run->rms, identities, Gallery::kAllOthers));
      COHORT_ASSIGN_OR_RETURN(const Verification verification, VerifyPairs(scores));
      row[3] = FixedDecimal(found.ShareAtRank(1), 3);
      row[4] = FixedDecimal(100 * verification.equal_error_rate, 2);
      row[5] = FixedDecimal(verification.d_prime, 2);
    }
    table.rows.push_back(row);
  }
  evaluation.findings.tables.push_back(table);
  evaluation.findings.Check(
      "converged", PropertyClass::kOrdinal,
      "the default ends nearer to its fixed point than the thesis's 10 "
      "iterations",
      "",
      absl::StrCat(FixedDecimal(distances[1], 5), " and ", FixedDecimal(distances[0], 5), " mm"),
      distances[1] < distances[0]);
  return absl::OkStatus();
}

}  // namespace

absl::Status EvaluateAccuracy(Evaluation& evaluation, Lab& lab) {
  COHORT_RETURN_IF_ERROR(AddOrder(evaluation, lab));
  COHORT_RETURN_IF_ERROR(AddRecovery(evaluation));
  COHORT_RETURN_IF_ERROR(AddZeros(evaluation, lab));
  return AddConverged(evaluation, lab);
}

}  // namespace cohort
