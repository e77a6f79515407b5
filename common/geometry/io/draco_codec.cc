#include "common/geometry/io/draco_codec.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <memory>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#pragma GCC diagnostic pop

namespace cohort {
namespace {

// Of 0 (small) to 10 (fast). On scans of faces 3 gives the fewest bytes and half the time of 0.
constexpr int kSpeed = 3;
// Draco counts symbols in a table as long as the largest one: 4 GB and 14 s with 30 bits. Above
// this they are kept as they are, which costs a third more bytes.
constexpr int kMostCompressedBits = 24;

// ---- Encoding ----

/// One float position per point, in the order of the vertices.
void AddPositions(const TriangleMesh& mesh, draco::PointCloud& cloud) {
  const auto count = static_cast<uint32_t>(mesh.VertexCount());
  cloud.set_num_points(count);
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                 3 * sizeof(float), 0);
  draco::PointAttribute& positions = *cloud.attribute(cloud.AddAttribute(attribute, true, count));
  for (uint32_t v = 0; v < count; ++v) {
    const Eigen::Vector3f position = mesh.vertices.col(v).cast<float>();
    positions.SetAttributeValue(draco::AttributeValueIndex(v), position.data());
  }
}

draco::Encoder MakeEncoder(const DracoOptions& options) {
  draco::Encoder encoder;
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, options.position_bits);
  if (options.position_bits > kMostCompressedBits) {
    encoder.options().SetGlobalBool("use_built_in_attribute_compression", false);
  }
  return encoder;
}

draco::Status EncodeCloud(const TriangleMesh& mesh,
                          const DracoOptions& options,
                          draco::EncoderBuffer& buffer) {
  draco::PointCloud cloud;
  AddPositions(mesh, cloud);
  return MakeEncoder(options).EncodePointCloudToBuffer(cloud, &buffer);
}

draco::Status EncodeSurface(const TriangleMesh& mesh,
                            const DracoOptions& options,
                            draco::EncoderBuffer& buffer) {
  draco::Mesh surface;
  AddPositions(mesh, surface);
  surface.SetNumFaces(static_cast<size_t>(mesh.FaceCount()));
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    draco::Mesh::Face face;
    for (int corner = 0; corner < 3; ++corner) {
      face[static_cast<size_t>(corner)] =
          draco::PointIndex(static_cast<uint32_t>(mesh.faces(corner, f)));
    }
    surface.SetFace(draco::FaceIndex(static_cast<uint32_t>(f)), face);
  }
  draco::Encoder encoder = MakeEncoder(options);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  if (encoder.EncodeMeshToBuffer(surface, &buffer).ok()) {
    return draco::OkStatus();
  }
  // Edgebreaker cannot walk every surface; the sequential method takes any list of faces.
  buffer.Clear();
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  return encoder.EncodeMeshToBuffer(surface, &buffer);
}

// ---- Decoding ----

absl::Status Damaged(std::string_view reason) {
  return absl::DataLossError("Draco: " + std::string(reason));
}

/// LEB128, as Draco writes counts.
bool GetVarint(ByteReader& reader, uint64_t& value) {
  value = 0;
  uint8_t byte = 0x80;
  for (unsigned shift = 0; shift < 35 && (byte & 0x80U) != 0; shift += 7) {
    if (!reader.Get(byte)) {
      return false;
    }
    value |= uint64_t{byte & 0x7FU} << shift;
  }
  return (byte & 0x80U) == 0;
}

/// A cloud has its count twice, and the tree of positions in it goes on for as long as the second
/// one says: both must agree. Before that one lie the attributes, of which ours has one.
bool GetCloudPoints(ByteReader& reader, uint8_t method, uint64_t& points) {
  constexpr std::array<uint8_t, 7> kOurAttribute = {
      1, 1, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, 0, 0};
  uint32_t count = 0;
  bool found = reader.Get(count);
  points = count;
  if (method == draco::POINT_CLOUD_KD_TREE_ENCODING) {
    std::array<uint8_t, kOurAttribute.size()> attribute = {};
    uint8_t level = 0;
    uint32_t bits = 0;
    uint32_t tree_count = 0;
    found = found && reader.GetArray(std::span<uint8_t>(attribute)) && reader.Get(level) &&
            reader.Get(bits) && reader.Get(tree_count) && attribute == kOurAttribute &&
            tree_count == count;
  }
  return found;
}

/// Reads the counts that a Draco 2.2 stream announces.
bool GetCounts(
    ByteReader& reader, bool is_mesh, uint8_t method, uint64_t& points, uint64_t& faces) {
  faces = 0;
  if (!is_mesh) {
    return GetCloudPoints(reader, method, points);
  }
  if (method == draco::MESH_SEQUENTIAL_ENCODING) {
    return GetVarint(reader, faces) && GetVarint(reader, points);
  }
  uint8_t traversal = 0;
  // What follows (symbols, splits) is at most the number of faces; Draco checks that itself.
  return reader.Get(traversal) && GetVarint(reader, points) && GetVarint(reader, faces);
}

/// Draco allocates what the header announces before it looks further, so the header comes first.
absl::Status CheckHeader(std::string_view bytes, int64_t max_vertices) {
  constexpr std::string_view kMagic = "DRACO";
  constexpr uint64_t kMostFacesPerVertex = 6;  // 2 in a closed surface; more only in odd meshes.
  if (!bytes.starts_with(kMagic)) {
    return Damaged("the bytes do not begin with 'DRACO'");
  }
  ByteReader reader(bytes.substr(kMagic.size()));
  std::array<uint8_t, 4> head = {};  // Major and minor version, geometry, method.
  uint16_t flags = 0;
  if (!reader.GetArray(std::span<uint8_t>(head)) || !reader.Get(flags)) {
    return Damaged("the header is cut off");
  }
  const auto [major, minor, geometry, method] = head;
  if (major != 2 || minor < 2 || minor > 3 || flags != 0 || geometry > 1 || method > 1) {
    return Damaged("not a stream as Cohort writes it (version 2.2 without metadata)");
  }
  uint64_t points = 0;
  uint64_t faces = 0;
  if (!GetCounts(reader, geometry == draco::TRIANGULAR_MESH, method, points, faces)) {
    return Damaged("the counts are cut off or contradict each other");
  }
  const auto limit = static_cast<uint64_t>(max_vertices);
  if (points > limit || faces > kMostFacesPerVertex * limit) {
    return Damaged(absl::StrCat(points, " vertices and ", faces, " faces announced; the limit is ",
                                limit, " vertices"));
  }
  return absl::OkStatus();
}

absl::Status CopyVertices(const draco::PointCloud& cloud, TriangleMesh& mesh) {
  const draco::PointAttribute* positions =
      cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (positions == nullptr || positions->num_components() != 3 ||
      positions->data_type() != draco::DT_FLOAT32) {
    return Damaged("no positions of three 32-bit floats");
  }
  mesh.vertices.resize(3, cloud.num_points());
  for (uint32_t v = 0; v < cloud.num_points(); ++v) {
    const draco::AttributeValueIndex value = positions->mapped_index(draco::PointIndex(v));
    if (value.value() >= positions->size()) {
      return Damaged(absl::StrCat("vertex ", v, " has no position"));
    }
    Eigen::Vector3f position;
    positions->GetValue(value, position.data());
    if (!position.allFinite()) {
      return Damaged(absl::StrCat("vertex ", v, " is not finite"));
    }
    mesh.vertices.col(v) = position.cast<double>();
  }
  return absl::OkStatus();
}

absl::Status CopyFaces(const draco::Mesh& surface, TriangleMesh& mesh) {
  mesh.faces.resize(3, surface.num_faces());
  for (uint32_t f = 0; f < surface.num_faces(); ++f) {
    const draco::Mesh::Face& face = surface.face(draco::FaceIndex(f));
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = face[corner].value();
      if (vertex >= surface.num_points() || face[corner] == face[(corner + 1) % 3]) {
        return Damaged(absl::StrCat("face ", f, " uses vertex ", vertex, " of ",
                                    surface.num_points(), ", or one twice"));
      }
      mesh.faces(corner, f) = static_cast<int32_t>(vertex);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<TriangleMesh> DecodeChecked(std::string_view bytes, int64_t max_vertices) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  const draco::StatusOr<draco::EncodedGeometryType> geometry =
      draco::Decoder::GetEncodedGeometryType(&buffer);
  if (!geometry.ok()) {
    return Damaged(geometry.status().error_msg_string());
  }
  std::unique_ptr<draco::PointCloud> cloud;
  if (geometry.value() == draco::TRIANGULAR_MESH) {
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) {
      return Damaged(decoded.status().error_msg_string());
    }
    cloud = std::move(decoded).value();
  } else {
    auto decoded = draco::Decoder().DecodePointCloudFromBuffer(&buffer);
    if (!decoded.ok()) {
      return Damaged(decoded.status().error_msg_string());
    }
    cloud = std::move(decoded).value();
  }
  if (cloud->num_points() < 1 || cloud->num_points() > max_vertices) {
    return Damaged(absl::StrCat(cloud->num_points(), " vertices; 1 to ", max_vertices, " allowed"));
  }
  TriangleMesh mesh;
  COHORT_RETURN_IF_ERROR(CopyVertices(*cloud, mesh));
  if (const auto* surface = dynamic_cast<const draco::Mesh*>(cloud.get()); surface != nullptr) {
    COHORT_RETURN_IF_ERROR(CopyFaces(*surface, mesh));
  }
  return mesh;
}

}  // namespace

absl::Status DracoOptions::Validate() const {
  if (position_bits < 8 || position_bits > 30) {
    return absl::InvalidArgumentError(
        absl::StrCat("position_bits is ", position_bits, "; 8 to 30 are possible"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> EncodeDraco(const TriangleMesh& mesh, const DracoOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (mesh.VertexCount() == 0) {
    return absl::InvalidArgumentError("a mesh without vertices cannot be encoded");
  }
  draco::EncoderBuffer buffer;
  const draco::Status status = mesh.IsPointCloud() ? EncodeCloud(mesh, options, buffer)
                                                   : EncodeSurface(mesh, options, buffer);
  if (!status.ok()) {
    return absl::InternalError("Draco: " + status.error_msg_string());
  }
  return std::string(buffer.data(), buffer.size());
}

absl::StatusOr<TriangleMesh> DecodeDraco(std::string_view bytes, int64_t max_vertices) {
  COHORT_RETURN_IF_ERROR(CheckHeader(bytes, max_vertices));
  // The one place in the geometry where a library's exception is expected: Draco's containers throw
  // std::length_error and std::bad_alloc on damaged bytes, and that is the blob's fault, not ours.
  try {
    return DecodeChecked(bytes, max_vertices);
  } catch (const std::exception& error) {
    return Damaged(error.what());
  }
}

}  // namespace cohort
