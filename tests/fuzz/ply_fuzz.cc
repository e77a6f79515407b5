#include "common/geometry/io/ply.h"
#include "tests/fuzz/fuzz_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace cohort;  // NOLINT(google-build-using-namespace)
  RequireGoodAnswer(ReadPly(AsText(bytes, size), "fuzz.ply", kFuzzLimits));
  RequireGoodAnswer(ReadMesh(AsText(bytes, size), "fuzz.ply", kFuzzLimits));
  return 0;
}
