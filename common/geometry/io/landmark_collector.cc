#include "common/geometry/io/landmark_collector.h"

#include <algorithm>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/text.h"

namespace cohort {

absl::Status LandmarkCollector::Error(const std::string& place, const std::string& reason) const {
  return FileError(file_, absl::StrCat(place, ": ", reason));
}

absl::Status LandmarkCollector::CheckName(const std::string& place, std::string_view name) const {
  if (name.empty()) {
    return Error(place, "the landmark has no name");
  }
  if (static_cast<int64_t>(name.size()) > limits_.max_name_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(file_, ": ", place, ": a name of ",
                                                     name.size(), " bytes; the limit is ",
                                                     limits_.max_name_bytes));
  }
  const bool printable = std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
  });
  if (!printable) {
    return Error(place, absl::StrCat("the name ", Quoted(name), " has control characters"));
  }
  return absl::OkStatus();
}

size_t LandmarkCollector::PlaceOf(std::string_view mesh) {
  const auto found = place_of_.find(mesh);
  if (found != place_of_.end()) {
    return found->second;
  }
  place_of_.emplace(mesh, meshes_.size());
  meshes_.emplace_back(mesh);
  gathered_.emplace_back();
  return meshes_.size() - 1;
}

absl::Status LandmarkCollector::AddMissing(const std::string& place,
                                           std::string_view mesh,
                                           std::string_view name) {
  COHORT_RETURN_IF_ERROR(CheckName(place, name));
  if (static_cast<int64_t>(first_place_.size()) >= limits_.max_landmarks) {
    return absl::ResourceExhaustedError(absl::StrCat(
        file_, ": ", place, ": more landmarks than the limit of ", limits_.max_landmarks));
  }
  const auto [first, is_new] = first_place_.try_emplace({PlaceOf(mesh), std::string(name)}, place);
  if (!is_new) {
    return Error(
        place, absl::StrCat("landmark ", Quoted(name), " is there already (", first->second, ")"));
  }
  return absl::OkStatus();
}

absl::Status LandmarkCollector::Add(const std::string& place,
                                    std::string_view mesh,
                                    std::string_view name,
                                    const Eigen::Vector3d& point) {
  COHORT_RETURN_IF_ERROR(AddMissing(place, mesh, name));
  Gathered& gathered = gathered_[PlaceOf(mesh)];
  gathered.names.emplace_back(name);
  gathered.points.push_back(point);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<MeshLandmarks>> LandmarkCollector::Take() && {
  if (first_place_.empty()) {
    return FileError(file_, "no landmarks in it");
  }
  std::vector<MeshLandmarks> meshes;
  for (size_t m = 0; m < meshes_.size(); ++m) {
    MeshLandmarks entry;
    entry.mesh = std::move(meshes_[m]);
    entry.landmarks.names = std::move(gathered_[m].names);
    entry.landmarks.points.resize(3, static_cast<Eigen::Index>(gathered_[m].points.size()));
    for (size_t i = 0; i < gathered_[m].points.size(); ++i) {
      entry.landmarks.points.col(static_cast<Eigen::Index>(i)) = gathered_[m].points[i];
    }
    meshes.push_back(std::move(entry));
  }
  return meshes;
}

}  // namespace cohort
