#include "common/rpc/convert_outputs.h"

#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

using WireDigests = google::protobuf::RepeatedPtrField<std::string>;

WireDigests ToWire(const std::vector<Digest>& digests) {
  WireDigests wire;
  for (const Digest& digest : digests) {
    *wire.Add() = digest.Hex();
  }
  return wire;
}

absl::Status Read(const WireDigests& wire, std::vector<Digest>& digests) {
  for (const std::string& hex : wire) {
    COHORT_ASSIGN_OR_RETURN(Digest digest, Digest::FromHex(hex));
    digests.push_back(std::move(digest));
  }
  return absl::OkStatus();
}

/// Empty text is an empty digest.
absl::Status Read(const std::string& wire, Digest& digest) {
  if (!wire.empty()) {
    COHORT_ASSIGN_OR_RETURN(digest, Digest::FromHex(wire));
  }
  return absl::OkStatus();
}

absl::Status ReadFrame(const v1::GetOutputsResponse& wire, CommonFrame& frame) {
  COHORT_RETURN_IF_ERROR(Read(wire.frame_reference_sha256(), frame.reference));
  const auto& center = wire.frame_center();
  if (!center.empty() && center.size() != std::ssize(frame.center)) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame_center: 3 numbers expected, got ", center.size()));
  }
  std::copy(center.begin(), center.end(), frame.center.begin());
  return absl::OkStatus();
}

}  // namespace

v1::GetOutputsResponse ToProto(const JobOutputs& outputs) {
  v1::GetOutputsResponse wire;
  *wire.mutable_tile_sha256() = ToWire(outputs.tiles);
  *wire.mutable_alignment_sha256() = ToWire(outputs.alignments);
  *wire.mutable_pose_sha256() = ToWire(outputs.poses);
  *wire.mutable_field_sha256() = ToWire(outputs.fields);
  *wire.mutable_signature_sha256() = ToWire(outputs.signatures);
  wire.set_mean_shape_sha256(outputs.mean_shape.Hex());
  wire.set_summary_sha256(outputs.summary.Hex());
  wire.set_variation_shape_sha256(outputs.variation_shape.Hex());
  wire.set_base_choice_sha256(outputs.base_choice.Hex());
  wire.set_frame_reference_sha256(outputs.frame.reference.Hex());
  wire.mutable_frame_center()->Add(outputs.frame.center.begin(), outputs.frame.center.end());
  for (const ImportedPairs& pairs : outputs.imported) {
    v1::ImportedPairs& sent = *wire.add_imported();
    *sent.mutable_tile_sha256() = ToWire(pairs.tiles);
    *sent.mutable_field_sha256() = ToWire(pairs.fields);
    sent.mutable_mesh_of()->Add(pairs.mesh_of.begin(), pairs.mesh_of.end());
  }
  return wire;
}

absl::StatusOr<JobOutputs> FromProto(const v1::GetOutputsResponse& wire) {
  JobOutputs outputs;
  COHORT_RETURN_IF_ERROR(Read(wire.tile_sha256(), outputs.tiles));
  COHORT_RETURN_IF_ERROR(Read(wire.alignment_sha256(), outputs.alignments));
  COHORT_RETURN_IF_ERROR(Read(wire.pose_sha256(), outputs.poses));
  COHORT_RETURN_IF_ERROR(Read(wire.field_sha256(), outputs.fields));
  COHORT_RETURN_IF_ERROR(Read(wire.signature_sha256(), outputs.signatures));
  COHORT_RETURN_IF_ERROR(Read(wire.mean_shape_sha256(), outputs.mean_shape));
  COHORT_RETURN_IF_ERROR(Read(wire.summary_sha256(), outputs.summary));
  COHORT_RETURN_IF_ERROR(Read(wire.variation_shape_sha256(), outputs.variation_shape));
  COHORT_RETURN_IF_ERROR(Read(wire.base_choice_sha256(), outputs.base_choice));
  COHORT_RETURN_IF_ERROR(ReadFrame(wire, outputs.frame));
  for (const v1::ImportedPairs& sent : wire.imported()) {
    ImportedPairs pairs;
    COHORT_RETURN_IF_ERROR(Read(sent.tile_sha256(), pairs.tiles));
    COHORT_RETURN_IF_ERROR(Read(sent.field_sha256(), pairs.fields));
    pairs.mesh_of.assign(sent.mesh_of().begin(), sent.mesh_of().end());
    outputs.imported.push_back(std::move(pairs));
  }
  return outputs;
}

}  // namespace cohort
