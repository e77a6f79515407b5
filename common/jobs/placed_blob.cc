#include "common/jobs/placed_blob.h"

#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/jobs/blob_decoder.h"

namespace cohort {
namespace {

constexpr std::string_view kMagic = "COHPLCD1";
constexpr uint64_t kHeaderBytes = sizeof(int32_t) + sizeof(uint64_t);
constexpr uint64_t kPointBytes = 3 * sizeof(float);

absl::Status GetMesh(BlobDecoder& blob, PlacedMesh& placed) {
  uint64_t n = 0;
  COHORT_RETURN_IF_ERROR(blob.Get("mesh index", placed.mesh));
  COHORT_RETURN_IF_ERROR(blob.GetCount("vertices", kPointBytes, n));
  if (n == 0) {
    return blob.Damaged(absl::StrCat("mesh ", placed.mesh, " has no vertices"));
  }
  placed.vertices.resize(3, static_cast<Eigen::Index>(n));
  COHORT_RETURN_IF_ERROR(
      blob.GetArray<float>("vertices", {placed.vertices.data(), static_cast<size_t>(3 * n)}));
  if (!placed.vertices.allFinite()) {
    return blob.Damaged(absl::StrCat("mesh ", placed.mesh, " is not finite"));
  }
  return absl::OkStatus();
}

}  // namespace

std::string EncodePlacedBlob(const std::vector<PlacedMesh>& meshes) {
  ByteWriter writer;
  writer.PutBytes(kMagic);
  writer.Put<uint64_t>(meshes.size());
  for (const PlacedMesh& placed : meshes) {
    writer.Put<int32_t>(placed.mesh);
    writer.Put<uint64_t>(static_cast<uint64_t>(placed.vertices.cols()));
    writer.PutArray<float>({placed.vertices.data(), static_cast<size_t>(placed.vertices.size())});
  }
  return std::move(writer).Take();
}

absl::StatusOr<std::vector<PlacedMesh>> DecodePlacedBlob(std::string_view bytes) {
  BlobDecoder blob("placed", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kMagic));
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("meshes", kHeaderBytes, count));
  std::vector<PlacedMesh> meshes(count);
  int32_t last = -1;
  for (PlacedMesh& placed : meshes) {
    COHORT_RETURN_IF_ERROR(GetMesh(blob, placed));
    if (placed.mesh <= last) {
      return blob.Damaged(absl::StrCat("mesh ", placed.mesh, " after ", last));
    }
    last = placed.mesh;
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return meshes;
}

}  // namespace cohort
