#include "tests/fuzz/fuzz_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace cohort;  // NOLINT(google-build-using-namespace)
  absl::StatusOr<TriangleMesh> mesh = DecodeDraco(AsText(bytes, size), kFuzzLimits.max_vertices);
  if (mesh.ok()) {
    RequireMeshSurvives(*std::move(mesh));
  } else if (mesh.status().code() != absl::StatusCode::kDataLoss) {
    Require(mesh.status(), "refused with a surprising code");
  }
  return 0;
}
