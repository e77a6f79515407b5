#include "worker/tasks/shared_meshes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "common/base/sha256.h"

namespace cohort {
namespace {

constexpr std::string_view kLayout = "packed mesh 1 ";  ///< Grows with every change of the layout.

/// Layout: uint64 vertex count, uint64 slots, then int32 vertex of each slot, 3 float32 a slot as
/// PackedMesh::View has them. A multiple of 8 bytes stands before the arrays.
using Counts = std::array<uint64_t, 2>;

Digest NameOf(std::string_view key) {
  return Sha256::Of(std::string(kLayout) + std::string(key));
}

template <typename T>
std::string_view BytesOf(std::span<const T> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

/// Of bytes that Keep wrote.
std::shared_ptr<const PackedMesh> Decode(std::string_view bytes) {
  Counts counts = {};
  if (bytes.size() < sizeof(counts)) {
    return nullptr;
  }
  std::memcpy(counts.data(), bytes.data(), sizeof(counts));
  const auto [vertices, slots] = counts;
  if (bytes.size() != sizeof(counts) + slots * (sizeof(int32_t) + 3 * sizeof(float))) {
    return nullptr;
  }
  const char* arrays = bytes.data() + sizeof(counts);
  const std::span order(reinterpret_cast<const int32_t*>(arrays), slots);
  const std::span points(reinterpret_cast<const float*>(arrays + order.size_bytes()), 3 * slots);
  return std::make_shared<const PackedMesh>(
      PackedMesh::FromSlots(static_cast<int>(vertices), order, points));
}

}  // namespace

std::shared_ptr<const PackedMesh> SharedMeshes::Get(std::string_view key) {
  std::shared_ptr<const PackedMesh> mesh;
  (void)folder_.Get(NameOf(key), [&](std::string_view bytes) { mesh = Decode(bytes); });
  return mesh;
}

void SharedMeshes::Keep(std::string_view key, const PackedMesh& mesh) {
  const auto slots = static_cast<size_t>(mesh.SlotCount());
  const Counts counts = {static_cast<uint64_t>(mesh.VertexCount()), slots};
  const std::array pieces = {BytesOf(std::span<const uint64_t>(counts)),
                             BytesOf(mesh.VertexOfSlot()),
                             BytesOf(std::span(mesh.Addresses().points, 3 * slots))};
  folder_.Keep(NameOf(key), pieces);
}

}  // namespace cohort
