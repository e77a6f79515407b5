#include "common/jobs/preview_blobs.h"

#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/jobs/blob_decoder.h"

namespace cohort {
namespace {

constexpr std::string_view kFloatCorrespondenceMagic = "COHCORR1";
constexpr std::string_view kCorrespondenceMagic = "COHCORR2";
constexpr std::string_view kPreviewMagic = "COHPREV1";

/// One mesh of COHCORR1.
absl::Status GetFloatField(BlobDecoder& blob, DisplacementFields& fields) {
  Eigen::Matrix3Xf field(3, fields.VertexCount());
  COHORT_RETURN_IF_ERROR(
      blob.GetArray<float>("field", {field.data(), static_cast<size_t>(field.size())}));
  if (!field.allFinite()) {
    return blob.Damaged("a displacement is not finite");
  }
  fields.Add(field);
  return absl::OkStatus();
}

absl::Status GetField(BlobDecoder& blob, DisplacementFields& fields) {
  int32_t step_exponent = 0;
  std::vector<int16_t> values(static_cast<size_t>(3 * fields.VertexCount()));
  COHORT_RETURN_IF_ERROR(blob.Get("step", step_exponent));
  COHORT_RETURN_IF_ERROR(blob.GetArray<int16_t>("field", values));
  if (!DisplacementFields::MayAdd(step_exponent, values)) {
    return blob.Damaged(absl::StrCat("field ", fields.MeshCount(), " with steps of 2^",
                                     step_exponent, " has a step or a value out of range"));
  }
  fields.AddSteps(step_exponent, values);
  return absl::OkStatus();
}

}  // namespace

std::string EncodeCorrespondenceBlob(const CorrespondencePart& part) {
  ByteWriter writer;
  writer.PutBytes(kCorrespondenceMagic);
  writer.Put<uint64_t>(static_cast<uint64_t>(part.fields.VertexCount()));
  writer.Put<uint64_t>(part.meshes.size());
  writer.PutArray<int32_t>(part.meshes);
  for (int64_t mesh = 0; mesh < part.fields.MeshCount(); ++mesh) {
    writer.Put(part.fields.StepExponent(mesh));
    writer.PutArray(part.fields.Values(mesh));
  }
  return std::move(writer).Take();
}

absl::StatusOr<CorrespondencePart> DecodeCorrespondenceBlob(std::string_view bytes) {
  BlobDecoder blob("correspondence", bytes);
  const bool is_float = bytes.starts_with(kFloatCorrespondenceMagic);
  COHORT_RETURN_IF_ERROR(blob.Start(is_float ? kFloatCorrespondenceMagic : kCorrespondenceMagic));
  const uint64_t point_bytes = 3 * (is_float ? sizeof(float) : sizeof(int16_t));
  uint64_t vertices = 0;
  uint64_t meshes = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("vertices", point_bytes, vertices));
  COHORT_RETURN_IF_ERROR(blob.Get("meshes", meshes));
  if (vertices == 0) {
    return blob.Damaged("no vertices");
  }
  CorrespondencePart part{.meshes = {},
                          .fields = DisplacementFields(static_cast<int64_t>(vertices))};
  COHORT_RETURN_IF_ERROR(blob.GetIndices(meshes, part.meshes));
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("fields", meshes, vertices * point_bytes));
  for (uint64_t mesh = 0; mesh < meshes; ++mesh) {
    COHORT_RETURN_IF_ERROR(is_float ? GetFloatField(blob, part.fields)
                                    : GetField(blob, part.fields));
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
