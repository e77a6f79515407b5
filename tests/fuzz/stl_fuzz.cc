#include "common/geometry/io/stl.h"
#include "tests/fuzz/fuzz_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace cohort;  // NOLINT(google-build-using-namespace)
  RequireGoodAnswer(ReadStl(AsText(bytes, size), "fuzz.stl", kFuzzLimits));
  RequireGoodAnswer(ReadMesh(AsText(bytes, size), "fuzz.stl", kFuzzLimits));
  return 0;
}
