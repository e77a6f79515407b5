#include "common/geometry/io/obj.h"
#include "tests/fuzz/fuzz_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace cohort;  // NOLINT(google-build-using-namespace)
  RequireGoodAnswer(ReadObj(AsText(bytes, size), "fuzz.obj", kFuzzLimits));
  RequireGoodAnswer(ReadMesh(AsText(bytes, size), "fuzz.obj", kFuzzLimits));
  return 0;
}
