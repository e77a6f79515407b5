#include "client/signatures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/group_variation.h"
#include "common/base/status_macros.h"
#include "common/jobs/preview_blobs.h"
#include "common/pairs/signature.h"

namespace cohort {
namespace {

/// Places 0..n-1 by ascending value, ties by place, NaN last.
template <typename ValueOf>
std::vector<int64_t> Ascending(int64_t n, ValueOf value_of) {
  std::vector<int64_t> places(static_cast<size_t>(n));
  std::iota(places.begin(), places.end(), int64_t{0});
  std::sort(places.begin(), places.end(), [&](int64_t a, int64_t b) {
    const double left = value_of(a);
    const double right = value_of(b);
    if (std::isnan(left) || std::isnan(right)) {
      return !std::isnan(left) || (std::isnan(right) && a < b);
    }
    return left != right ? left < right : a < b;
  });
  return places;
}

absl::Status NoSignatures(const JobFrame& frame, const std::string& why) {
  return absl::NotFoundError(absl::StrCat("job ", frame.GetJob().id.value, " has no signatures",
                                          why, ": --shortlist 0 compares all meshes"));
}

}  // namespace

absl::StatusOr<Signatures> Signatures::Load(const JobFrame& frame) {
  std::vector<CorrespondencePart> parts;
  std::map<int32_t, std::pair<size_t, int64_t>> place_of;
  for (const Digest& blob : frame.Outputs().signatures) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, frame.Blobs().Get(blob));
    COHORT_ASSIGN_OR_RETURN(CorrespondencePart part, DecodeCorrespondenceBlob(bytes));
    for (size_t k = 0; k < part.meshes.size(); ++k) {
      place_of[part.meshes[k]] = {parts.size(), static_cast<int64_t>(k)};
    }
    parts.push_back(std::move(part));
  }
  if (parts.empty()) {
    return NoSignatures(frame, "");
  }
  Signatures signatures(parts.front().fields.VertexCount());
  for (const int32_t mesh : frame.Active()) {
    const auto found = place_of.find(mesh);
    if (found == place_of.end()) {
      return NoSignatures(frame, " of mesh " + frame.Meshes()[static_cast<size_t>(mesh)].mesh.name);
    }
    const DisplacementFields& fields = parts[found->second.first].fields;
    if (fields.VertexCount() != signatures.fields_.VertexCount()) {
      return absl::DataLossError(
          absl::StrCat("job ", frame.GetJob().id.value, ": its signatures have ",
                       signatures.fields_.VertexCount(), " and ", fields.VertexCount(), " points"));
    }
    const int64_t at = found->second.second;
    signatures.fields_.AddSteps(fields.StepExponent(at), fields.Values(at));
    signatures.meshes_.push_back(mesh);
  }
  return signatures;
}

std::vector<int64_t> Signatures::Order(const DisplacementFields& one) const {
  const Eigen::MatrixXd distances = CorrespondedRms(one, fields_);
  return Ascending(distances.cols(), [&](int64_t place) { return distances(0, place); });
}

absl::StatusOr<std::vector<int32_t>> Signatures::Nearest(const JobFrame& frame,
                                                         const Probe& probe,
                                                         int64_t count) const {
  COHORT_ASSIGN_OR_RETURN(const TriangleMesh reference, frame.LoadReference());
  const std::vector<int32_t> at = SignatureVertices(reference.VertexCount());
  if (std::ssize(at) != fields_.VertexCount()) {
    return absl::DataLossError(
        absl::StrCat("job ", frame.GetJob().id.value, ": its signatures do not fit its reference"));
  }
  const Eigen::Matrix3Xd vertices = reference.vertices(Eigen::all, at);
  DisplacementFields one(fields_.VertexCount());
  one.Add(DisplacementsTo(probe.framed, vertices, IcpMesh(vertices),
                          frame.GetJob().spec.icp.correspondence)
              .cast<float>());
  const std::vector<int64_t> order = Order(one);
  std::vector<int32_t> nearest;
  for (const int64_t place : order) {
    if (std::ssize(nearest) == count) {
      break;
    }
    nearest.push_back(meshes_[static_cast<size_t>(place)]);
  }
  return nearest;
}

double Signatures::Recall(const Eigen::Ref<const RowMajorMatrix>& exact,
                          int64_t top,
                          int64_t count,
                          int64_t probes) const {
  const auto meshes = static_cast<int64_t>(meshes_.size());
  probes = std::min(probes, meshes);
  double sum = 0;
  for (int64_t k = 0; k < probes; ++k) {
    const int64_t self = k * meshes / probes;
    DisplacementFields one(fields_.VertexCount());
    one.AddSteps(fields_.StepExponent(self), fields_.Values(self));
    const auto shorten = [self](std::vector<int64_t> order, int64_t length) {
      std::erase(order, self);
      order.resize(std::min(order.size(), static_cast<size_t>(length)));
      return order;
    };
    const std::vector<int64_t> wanted =
        shorten(Ascending(meshes, [&](int64_t place) { return exact(self, place); }), top);
    std::vector<int64_t> found = shorten(Order(one), count);
    std::sort(found.begin(), found.end());
    const auto hits = std::count_if(wanted.begin(), wanted.end(), [&](int64_t place) {
      return std::binary_search(found.begin(), found.end(), place);
    });
    sum += wanted.empty() ? 1 : static_cast<double>(hits) / static_cast<double>(wanted.size());
  }
  return sum / static_cast<double>(probes);
}

}  // namespace cohort
