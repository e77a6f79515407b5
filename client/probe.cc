#include "client/probe.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/files.h"
#include "common/base/status_macros.h"
#include "common/geometry/registration/mirror.h"
#include "common/pairs/align_mesh.h"
#include "common/pairs/canonical_mesh.h"
#include "common/pairs/distance_finder.h"
#include "common/pairs/kept_distances.h"

namespace cohort {
namespace {

absl::Status Named(const std::string& name, const absl::Status& status) {
  return absl::Status(status.code(), name + ": " + std::string(status.message()));
}

/// As the worker's tasks align the meshes of a job.
absl::StatusOr<Alignment> AlignToReference(const JobFrame& frame, const TriangleMesh& mesh) {
  const JobSpec& spec = frame.GetJob().spec;
  if (spec.method == Method::kNone) {
    return Alignment{};
  }
  COHORT_ASSIGN_OR_RETURN(const TriangleMesh reference, frame.LoadReference());
  return AlignMeshTo(mesh, reference, spec);
}

double OneValue(const Match& match, Symmetrization symmetrization) {
  switch (symmetrization) {
    case Symmetrization::kMean:
      return (match.from_probe + match.to_probe) / 2;
    case Symmetrization::kMax:
      return std::isnan(match.to_probe) ? match.to_probe
                                        : std::max(match.to_probe, match.from_probe);
    case Symmetrization::kDirected:
      break;
  }
  return match.from_probe;
}

/// Nearest first; NaN last.
bool IsNearer(const Match& a, const Match& b) {
  if (std::isnan(a.value) || std::isnan(b.value)) {
    return !std::isnan(a.value) || (std::isnan(b.value) && a.mesh < b.mesh);
  }
  return a.value != b.value ? a.value < b.value : a.mesh < b.mesh;
}

}  // namespace

absl::StatusOr<Probe> AlignProbe(const JobFrame& frame,
                                 const std::filesystem::path& file,
                                 const PairMeshOptions& options) {
  COHORT_RETURN_IF_ERROR(frame.CheckHasFrame());
  const JobSpec& spec = frame.GetJob().spec;
  const std::string name = file.filename().string();
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, ReadWholeFile(file));
  COHORT_ASSIGN_OR_RETURN(CanonicalMesh canonical, MakeCanonical(bytes, name, spec.position_bits));
  if (spec.symmetric_copies) {
    PacketSearch search;
    absl::StatusOr<SymmetricMesh> copy = MakeSymmetric(canonical.mesh, spec.icp, search);
    if (!copy.ok()) return Named(name, copy.status());
    canonical.mesh = std::move(copy->mesh);
  }
  const absl::StatusOr<Alignment> alignment = AlignToReference(frame, canonical.mesh);
  if (!alignment.ok()) return Named(name, alignment.status());
  absl::StatusOr<PairMesh> placed =
      MakePairMesh(canonical.mesh, alignment->T_target_source, frame.Center(), options);
  if (!placed.ok()) return Named(name, placed.status());
  return Probe{
      .name = name,
      .health = std::move(canonical.health),
      .alignment = *alignment,
      .framed = {std::move(canonical.mesh), alignment->T_target_source, *std::move(placed)}};
}

absl::StatusOr<std::vector<Match>> RankMeshes(const JobFrame& frame,
                                              const Probe& probe,
                                              const std::vector<int32_t>& meshes,
                                              const MeasureSpec& measure,
                                              Symmetrization symmetrization,
                                              Executor& executor) {
  const CompareOptions& compare = frame.GetJob().spec.compare;
  std::vector<Match> matches(meshes.size());
  std::vector<absl::Status> statuses(meshes.size());
  const auto measure_one = [&](size_t place) -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(const FramedMesh mesh,
                            frame.Load(meshes[place], {.compare = compare, .sign = measure.sign}));
    DistanceFinder finder(compare, measure.sign);
    const auto value = [&](const FramedMesh& from,
                           const FramedMesh& to) -> absl::StatusOr<PairValue> {
      const PairDistances& found = finder.Find(from.placed, to.placed);
      std::vector<double> weights;
      if (measure.by_area) {
        const std::vector<double> all =
            SlotWeights(from.mesh, from.placed.vertices, /*by_area=*/true, nullptr);
        for (const int32_t slot : found.slots) {
          weights.push_back(all[static_cast<size_t>(slot)]);
        }
      }
      return MeasurePair(found.distances, weights, measure);
    };
    COHORT_ASSIGN_OR_RETURN(const PairValue there, value(probe.framed, mesh));
    COHORT_ASSIGN_OR_RETURN(const PairValue back, value(mesh, probe.framed));
    Match& match = matches[place];
    match = {.mesh = meshes[place], .from_probe = there.value, .to_probe = back.value};
    match.value = OneValue(match, symmetrization);
    return absl::OkStatus();
  };
  executor.ParallelFor(std::ssize(meshes), [&](int64_t i) {
    statuses[static_cast<size_t>(i)] = measure_one(static_cast<size_t>(i));
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  std::sort(matches.begin(), matches.end(), IsNearer);
  return matches;
}

}  // namespace cohort
