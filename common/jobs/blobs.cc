#include "common/jobs/blobs.h"

#include <algorithm>
#include <span>
#include <utility>

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/jobs/blob_decoder.h"

namespace cohort {
namespace {

constexpr std::string_view kAlignmentMagic = "COHALGN2";
constexpr std::string_view kDisplacementMagic = "COHDISP2";
constexpr std::string_view kTileMagic = "COHTILE1";
constexpr std::string_view kVariationMagic = "COHVARI3";
constexpr std::string_view kSummaryMagic = "COHSUMM1";
constexpr std::string_view kBaseMagic = "COHBASE1";

constexpr uint64_t kAlignmentBytes =
    2 * sizeof(int32_t) + 2 + sizeof(int64_t) + 17 * sizeof(double);
constexpr uint64_t kPointBytes = 3 * sizeof(float);
constexpr uint64_t kValuesBytes = sizeof(MetricValues);
constexpr uint64_t kBlockHeaderBytes = 3 * sizeof(uint64_t);

void PutAlignment(ByteWriter& writer, const MeshAlignment& item) {
  const Similarity& T = item.alignment.T_target_source;
  writer.Put<int32_t>(item.mesh);
  writer.Put<int32_t>(item.alignment.iterations);
  writer.Put<uint8_t>(item.alignment.converged ? 1 : 0);
  writer.Put<int64_t>(item.alignment.lookups);
  writer.Put<double>(item.alignment.rms_residual);
  writer.Put<double>(item.alignment.mean_residual);
  writer.Put<uint8_t>(item.alignment.at_scale_limit ? 1 : 0);
  writer.Put<double>(item.alignment.overlap);
  writer.Put<double>(item.alignment.kept_share);
  writer.Put<double>(T.scale);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      writer.Put<double>(T.rotation(row, column));
    }
  }
  for (int row = 0; row < 3; ++row) {
    writer.Put<double>(T.translation(row));
  }
}

absl::Status GetAlignment(BlobDecoder& blob, MeshAlignment& item) {
  Similarity& T = item.alignment.T_target_source;
  uint8_t converged = 0;
  uint8_t at_scale_limit = 0;
  COHORT_RETURN_IF_ERROR(blob.Get("mesh index", item.mesh));
  COHORT_RETURN_IF_ERROR(blob.Get("iterations", item.alignment.iterations));
  COHORT_RETURN_IF_ERROR(blob.Get("converged", converged));
  COHORT_RETURN_IF_ERROR(blob.Get("lookups", item.alignment.lookups));
  COHORT_RETURN_IF_ERROR(blob.Get("rms", item.alignment.rms_residual));
  COHORT_RETURN_IF_ERROR(blob.Get("mean", item.alignment.mean_residual));
  COHORT_RETURN_IF_ERROR(blob.Get("at scale limit", at_scale_limit));
  COHORT_RETURN_IF_ERROR(blob.Get("overlap", item.alignment.overlap));
  COHORT_RETURN_IF_ERROR(blob.Get("kept share", item.alignment.kept_share));
  COHORT_RETURN_IF_ERROR(blob.Get("scale", T.scale));
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      COHORT_RETURN_IF_ERROR(blob.Get("rotation", T.rotation(row, column)));
    }
  }
  for (int row = 0; row < 3; ++row) {
    COHORT_RETURN_IF_ERROR(blob.Get("translation", T.translation(row)));
  }
  if (item.mesh < 0 || item.alignment.iterations < 0 || item.alignment.lookups < 0) {
    return blob.Damaged(absl::StrCat("negative number for mesh ", item.mesh));
  }
  if (converged > 1 || at_scale_limit > 1) {
    return blob.Damaged(absl::StrCat("flags are ", static_cast<int>(converged), " and ",
                                     static_cast<int>(at_scale_limit), " for mesh ", item.mesh));
  }
  item.alignment.converged = converged == 1;
  item.alignment.at_scale_limit = at_scale_limit == 1;
  return absl::OkStatus();
}

std::span<const float> Coefficients(const Eigen::Matrix3Xf& points) {
  return {points.data(), static_cast<size_t>(points.size())};
}

absl::Status GetPoints(BlobDecoder& blob, uint64_t count, Eigen::Matrix3Xf& points) {
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("points", count, kPointBytes));
  points.resize(3, static_cast<Eigen::Index>(count));
  return blob.GetArray<float>("points", {points.data(), static_cast<size_t>(points.size())});
}

absl::Status GetMeshCount(BlobDecoder& blob, int64_t& mesh_count) {
  COHORT_RETURN_IF_ERROR(blob.Get("mesh count", mesh_count));
  return mesh_count < 0 ? blob.Damaged(absl::StrCat("mesh count is ", mesh_count))
                        : absl::OkStatus();
}

absl::Status GetMetricNumber(BlobDecoder& blob) {
  uint64_t metrics = 0;
  COHORT_RETURN_IF_ERROR(blob.Get("number of metrics", metrics));
  return metrics == kMetricCount
             ? absl::OkStatus()
             : blob.Damaged(absl::StrCat("has ", metrics, " metrics, expected ", kMetricCount));
}

void PutValues(ByteWriter& writer, const std::vector<MetricValues>& values) {
  for (const MetricValues& item : values) {
    writer.PutArray<double>(item);
  }
}

absl::Status GetValues(BlobDecoder& blob, uint64_t count, std::vector<MetricValues>& values) {
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("metric values", count, kValuesBytes));
  values.resize(count);
  for (MetricValues& item : values) {
    COHORT_RETURN_IF_ERROR(blob.GetArray<double>("metric values", item));
  }
  return absl::OkStatus();
}

absl::Status GetBlock(BlobDecoder& blob, MetricBlock& block) {
  uint64_t rows = 0;
  uint64_t columns = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("rows", sizeof(int32_t), rows));
  COHORT_RETURN_IF_ERROR(blob.GetCount("columns", sizeof(int32_t), columns));
  COHORT_RETURN_IF_ERROR(GetMetricNumber(blob));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(rows, block.sources));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(columns, block.targets));
  // Each row on its own, so that rows * columns cannot overflow unseen.
  COHORT_RETURN_IF_ERROR(blob.CheckRoom("rows of values", rows, columns * kValuesBytes));
  return GetValues(blob, rows * columns, block.values);
}

}  // namespace

std::string EncodeAlignmentBlob(const std::vector<MeshAlignment>& alignments) {
  ByteWriter writer;
  writer.PutBytes(kAlignmentMagic);
  writer.Put<uint64_t>(alignments.size());
  for (const MeshAlignment& item : alignments) {
    PutAlignment(writer, item);
  }
  return std::move(writer).Take();
}

absl::StatusOr<std::vector<MeshAlignment>> DecodeAlignmentBlob(std::string_view bytes) {
  BlobDecoder blob("alignment", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kAlignmentMagic));
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("alignments", kAlignmentBytes, count));
  std::vector<MeshAlignment> alignments(count);
  for (MeshAlignment& item : alignments) {
    COHORT_RETURN_IF_ERROR(GetAlignment(blob, item));
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return alignments;
}

std::string EncodeDisplacementBlob(const DisplacementSum& displacement) {
  ByteWriter writer;
  writer.PutBytes(kDisplacementMagic);
  writer.Put<int64_t>(displacement.mesh_count);
  writer.Put<uint64_t>(static_cast<uint64_t>(displacement.sum.cols()));
  writer.PutArray<float>(Coefficients(displacement.sum));
  return std::move(writer).Take();
}

absl::StatusOr<DisplacementSum> DecodeDisplacementBlob(std::string_view bytes) {
  BlobDecoder blob("displacement", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kDisplacementMagic));
  DisplacementSum displacement;
  uint64_t n = 0;
  COHORT_RETURN_IF_ERROR(GetMeshCount(blob, displacement.mesh_count));
  COHORT_RETURN_IF_ERROR(blob.GetCount("vertices", kPointBytes, n));
  COHORT_RETURN_IF_ERROR(GetPoints(blob, n, displacement.sum));
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return displacement;
}

std::string EncodeTileBlob(const std::vector<MetricBlock>& blocks) {
  ByteWriter writer;
  writer.PutBytes(kTileMagic);
  writer.Put<uint64_t>(blocks.size());
  for (const MetricBlock& block : blocks) {
    writer.Put<uint64_t>(block.sources.size());
    writer.Put<uint64_t>(block.targets.size());
    writer.Put<uint64_t>(kMetricCount);
    writer.PutArray<int32_t>(block.sources);
    writer.PutArray<int32_t>(block.targets);
    PutValues(writer, block.values);
  }
  return std::move(writer).Take();
}

absl::StatusOr<std::vector<MetricBlock>> DecodeTileBlob(std::string_view bytes) {
  BlobDecoder blob("tile", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kTileMagic));
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("blocks", kBlockHeaderBytes, count));
  std::vector<MetricBlock> blocks(count);
  for (MetricBlock& block : blocks) {
    COHORT_RETURN_IF_ERROR(GetBlock(blob, block));
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return blocks;
}

std::string EncodeVariationBlob(const VariationPart& part) {
  ByteWriter writer;
  writer.PutBytes(kVariationMagic);
  writer.Put<uint64_t>(static_cast<uint64_t>(part.distances.rows()));
  writer.Put<uint64_t>(part.meshes.size());
  writer.PutArray<int32_t>(part.meshes);
  writer.PutArray<float>({part.distances.data(), static_cast<size_t>(part.distances.size())});
  writer.Put<int64_t>(part.displacement.mesh_count);
  writer.Put<uint64_t>(static_cast<uint64_t>(part.displacement.sum.cols()));
  writer.PutArray<float>(Coefficients(part.displacement.sum));
  return std::move(writer).Take();
}

absl::StatusOr<VariationPart> DecodeVariationBlob(std::string_view bytes) {
  BlobDecoder blob("variation", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kVariationMagic));
  VariationPart part;
  uint64_t n = 0;
  uint64_t meshes = 0;
  COHORT_RETURN_IF_ERROR(blob.Get("vertices", n));
  COHORT_RETURN_IF_ERROR(blob.Get("meshes", meshes));
  COHORT_RETURN_IF_ERROR(blob.GetIndices(meshes, part.meshes));
  COHORT_RETURN_IF_ERROR(
      blob.CheckRoom("vertices", n, std::max(meshes, uint64_t{1}) * sizeof(float)));
  part.distances.resize(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(meshes));
  COHORT_RETURN_IF_ERROR(blob.GetArray<float>(
      "distances", {part.distances.data(), static_cast<size_t>(part.distances.size())}));
  COHORT_RETURN_IF_ERROR(GetMeshCount(blob, part.displacement.mesh_count));
  uint64_t points = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("points", kPointBytes, points));
  if (points != 0 && points != n) {
    return blob.Damaged(absl::StrCat("has ", points, " displacements of ", n, " vertices"));
  }
  COHORT_RETURN_IF_ERROR(GetPoints(blob, points, part.displacement.sum));
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return part;
}

std::string EncodeSummaryBlob(const VariationSummary& summary) {
  ByteWriter writer;
  writer.PutBytes(kSummaryMagic);
  writer.Put<int64_t>(summary.mesh_count);
  writer.Put<uint64_t>(summary.values.size());
  writer.Put<uint64_t>(kMetricCount);
  PutValues(writer, summary.values);
  return std::move(writer).Take();
}

absl::StatusOr<VariationSummary> DecodeSummaryBlob(std::string_view bytes) {
  BlobDecoder blob("summary", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kSummaryMagic));
  VariationSummary summary;
  uint64_t n = 0;
  COHORT_RETURN_IF_ERROR(GetMeshCount(blob, summary.mesh_count));
  COHORT_RETURN_IF_ERROR(blob.GetCount("vertices", kValuesBytes, n));
  COHORT_RETURN_IF_ERROR(GetMetricNumber(blob));
  COHORT_RETURN_IF_ERROR(GetValues(blob, n, summary.values));
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return summary;
}

std::string EncodeBaseBlob(const BaseChoice& choice) {
  ByteWriter writer;
  writer.PutBytes(kBaseMagic);
  writer.Put<int32_t>(choice.base);
  writer.Put<uint64_t>(choice.candidates.size());
  for (const BaseChoice::Candidate& candidate : choice.candidates) {
    writer.Put<int32_t>(candidate.mesh);
    writer.Put<double>(candidate.mean_distance);
  }
  return std::move(writer).Take();
}

absl::StatusOr<BaseChoice> DecodeBaseBlob(std::string_view bytes) {
  BlobDecoder blob("base", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kBaseMagic));
  BaseChoice choice;
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.Get("base", choice.base));
  COHORT_RETURN_IF_ERROR(blob.GetCount("candidates", sizeof(int32_t) + sizeof(double), count));
  choice.candidates.resize(count);
  for (BaseChoice::Candidate& candidate : choice.candidates) {
    COHORT_RETURN_IF_ERROR(blob.Get("mesh", candidate.mesh));
    COHORT_RETURN_IF_ERROR(blob.Get("mean distance", candidate.mean_distance));
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return choice;
}

}  // namespace cohort
