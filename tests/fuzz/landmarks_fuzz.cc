#include <cstdint>

#include "common/geometry/io/landmarks.h"
#include "tests/fuzz/fuzz_mesh.h"

namespace cohort {
namespace {

constexpr LandmarkLimits kFewLandmarks = {
    .max_bytes = 1 << 20, .max_landmarks = 5000, .max_name_bytes = 256};

/// What was accepted is whole, and survives being written and read again.
void RequireLandmarksSurvive(const LandmarkSet& landmarks) {
  if (static_cast<int64_t>(landmarks.names.size()) != landmarks.Count() ||
      !landmarks.points.allFinite()) {
    Require(absl::InternalError("names and points do not match"), "ReadLandmarkTable");
  }
  if (landmarks.Count() == 0) {
    return;  // All were missing; a file without landmarks is refused.
  }
  const absl::StatusOr<LandmarkSet> back =
      ReadLandmarks(WriteLandmarksCsv(landmarks), "written.csv");
  Require(back.status(), "ReadLandmarks of WriteLandmarksCsv");
  if (back->names != landmarks.names || back->points != landmarks.points) {
    Require(absl::InternalError("came back changed"), "WriteLandmarksCsv");
  }
}

void RequireGoodTable(std::string_view bytes, std::string_view file_name) {
  const absl::StatusOr<std::vector<MeshLandmarks>> table =
      ReadLandmarkTable(bytes, file_name, kFewLandmarks);
  if (!table.ok()) {
    if (table.status().code() != absl::StatusCode::kInvalidArgument &&
        table.status().code() != absl::StatusCode::kResourceExhausted) {
      Require(table.status(), "refused with a surprising code");
    }
    return;
  }
  for (const MeshLandmarks& entry : *table) {
    RequireLandmarksSurvive(entry.landmarks);
  }
}

}  // namespace
}  // namespace cohort

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  // The content tells .pp and .mrk.json; the other two need the name.
  cohort::RequireGoodTable(cohort::AsText(bytes, size), "fuzz.csv");
  cohort::RequireGoodTable(cohort::AsText(bytes, size), "fuzz.fcsv");
  return 0;
}
