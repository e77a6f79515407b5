#include "common/jobs/preview_blobs.h"

#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/jobs/blob_decoder.h"

namespace cohort {
namespace {

constexpr std::string_view kCorrespondenceMagic = "COHCORR1";
constexpr std::string_view kPreviewMagic = "COHPREV1";
constexpr uint64_t kPointBytes = 3 * sizeof(float);

}  // namespace

std::string EncodeCorrespondenceBlob(const CorrespondencePart& part) {
  ByteWriter writer;
  writer.PutBytes(kCorrespondenceMagic);
  writer.Put<uint64_t>(static_cast<uint64_t>(part.fields.VertexCount()));
  writer.Put<uint64_t>(part.meshes.size());
  writer.PutArray<int32_t>(part.meshes);
  for (int64_t mesh = 0; mesh < part.fields.MeshCount(); ++mesh) {
    const auto field = part.fields.Of(mesh);
    writer.PutArray<float>({field.data(), static_cast<size_t>(field.size())});
  }
  return std::move(writer).Take();
}

absl::StatusOr<CorrespondencePart> DecodeCorrespondenceBlob(std::string_view bytes) {
  BlobDecoder blob("correspondence", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kCorrespondenceMagic));
  uint64_t vertices = 0;
  uint64_t meshes = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("vertices", kPointBytes, vertices));
  COHORT_RETURN_IF_ERROR(blob.Get("meshes", meshes));
  if (vertices == 0) {
    return blob.Damaged("no vertices");
  }
  CorrespondencePart part{.meshes = {},
                          .fields = DisplacementFields(static_cast<int64_t>(vertices))};
  COHORT_RETURN_IF_ERROR(blob.GetIndices(meshes, part.meshes));
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("fields", meshes, vertices * kPointBytes));
  Eigen::Matrix3Xf field(3, static_cast<Eigen::Index>(vertices));
  for (uint64_t mesh = 0; mesh < meshes; ++mesh) {
    COHORT_RETURN_IF_ERROR(
        blob.GetArray<float>("field", {field.data(), static_cast<size_t>(field.size())}));
    part.fields.Add(field);
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return part;
}

std::string EncodePreviewBlob(const PreviewBlock& block) {
  ByteWriter writer;
  writer.PutBytes(kPreviewMagic);
  writer.Put<uint64_t>(block.rows.size());
  writer.Put<uint64_t>(block.columns.size());
  writer.PutArray<int32_t>(block.rows);
  writer.PutArray<int32_t>(block.columns);
  writer.PutArray<double>(block.values);
  return std::move(writer).Take();
}

absl::StatusOr<PreviewBlock> DecodePreviewBlob(std::string_view bytes) {
  BlobDecoder blob("preview", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kPreviewMagic));
  PreviewBlock block;
  uint64_t rows = 0;
  uint64_t columns = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("rows", sizeof(int32_t), rows));
  COHORT_RETURN_IF_ERROR(blob.GetCount("columns", sizeof(int32_t), columns));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(rows, block.rows));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(columns, block.columns));
  // Each row on its own, so that rows * columns cannot overflow unseen.
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("rows of values", rows, columns * sizeof(double)));
  block.values.resize(rows * columns);
  COHORT_RETURN_IF_ERROR(blob.GetArray<double>("values", block.values));
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return block;
}

}  // namespace cohort
