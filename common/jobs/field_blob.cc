#include "common/jobs/field_blob.h"

#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/jobs/blob_decoder.h"

namespace cohort {
namespace {

constexpr std::string_view kMagic = "COHFLDS1";
constexpr uint64_t kBlockHeaderBytes = 2 * sizeof(uint64_t);
constexpr uint64_t kFieldHeaderBytes = sizeof(int64_t) + sizeof(uint64_t);

absl::Status GetBlock(BlobDecoder& blob, FieldBlock& block) {
  uint64_t rows = 0;
  uint64_t columns = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("rows", sizeof(int32_t), rows));
  COHORT_RETURN_IF_ERROR(blob.GetCount("columns", sizeof(int32_t), columns));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(rows, block.sources));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(columns, block.targets));
  // Each row on its own, so that rows * columns cannot overflow unseen.
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("rows of fields", rows, columns * kFieldHeaderBytes));
  block.fields.resize(rows * columns);
  for (KeptField& field : block.fields) {
    COHORT_RETURN_IF_ERROR(blob.Get("number of distances", field.values));
    if (field.values < 0) {
      return blob.Damaged(absl::StrCat("a field of ", field.values, " distances"));
    }
    COHORT_RETURN_IF_ERROR(blob.GetString("field", field.bytes));
  }
  return absl::OkStatus();
}

}  // namespace

std::string EncodeFieldBlob(const FieldBlob& blob) {
  ByteWriter writer;
  writer.PutBytes(kMagic);
  writer.Put<uint64_t>(static_cast<uint64_t>(blob.retention));
  writer.Put<uint64_t>(blob.blocks.size());
  for (const FieldBlock& block : blob.blocks) {
    writer.Put<uint64_t>(block.sources.size());
    writer.Put<uint64_t>(block.targets.size());
    writer.PutArray<int32_t>(block.sources);
    writer.PutArray<int32_t>(block.targets);
    for (const KeptField& field : block.fields) {
      writer.Put<int64_t>(field.values);
      writer.PutString(field.bytes);
    }
  }
  return std::move(writer).Take();
}

absl::StatusOr<FieldBlob> DecodeFieldBlob(std::string_view bytes) {
  BlobDecoder blob("field", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kMagic));
  FieldBlob fields;
  uint64_t retention = 0;
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.Get("retention", retention));
  if (retention >= static_cast<uint64_t>(Retention::kAuto)) {
    return blob.Damaged(absl::StrCat("retention ", retention, " is not known"));
  }
  fields.retention = static_cast<Retention>(retention);
  COHORT_RETURN_IF_ERROR(blob.GetCount("blocks", kBlockHeaderBytes, count));
  fields.blocks.resize(count);
  for (FieldBlock& block : fields.blocks) {
    COHORT_RETURN_IF_ERROR(GetBlock(blob, block));
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return fields;
}

}  // namespace cohort
