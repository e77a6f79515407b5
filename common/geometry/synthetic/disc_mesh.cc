#include "common/geometry/synthetic/disc_mesh.h"

#include <cassert>

namespace cohort {
namespace {

int Next(int k) {
  return (k + 1) % 3;
}

int Previous(int k) {
  return (k + 2) % 3;
}

size_t Index(int k) {
  return static_cast<size_t>(k);
}

}  // namespace

DiscMesh::DiscMesh(int32_t rim) {
  face_of_.assign(static_cast<size_t>(rim) + 1, 0);
  faces_.resize(static_cast<size_t>(rim));
  for (int32_t i = 0; i < rim; ++i) {
    const int32_t after = (i + 1) % rim;
    Set(i, {{0, i + 1, after + 1}, {(i + rim - 1) % rim, -1, after}});
  }
}

void DiscMesh::Set(int32_t face, const Face& value) {
  Mutable(face) = value;
  for (const int32_t v : value.v) {
    face_of_[static_cast<size_t>(v)] = face;
  }
}

int DiscMesh::SideOf(int32_t face, int32_t a, int32_t b) const {
  const Face& f = At(face);
  for (int k = 0; k < 3; ++k) {
    if (f.v[Index(k)] == a && f.v[Index(Next(k))] == b) {
      return k;
    }
  }
  return -1;
}

void DiscMesh::Relink(int32_t at, int32_t before, int32_t now) {
  if (at < 0) {
    return;
  }
  for (int32_t& next : Mutable(at).next) {
    if (next == before) {
      next = now;
      return;
    }
  }
  assert(false && "neighbours disagree");
}

int32_t DiscMesh::Split(int32_t face, int k, std::vector<int32_t>& changed) {
  const Face old = At(face);
  const int32_t a = old.v[Index(k)];
  const int32_t b = old.v[Index(Next(k))];
  const int32_t c = old.v[Index(Previous(k))];
  const int32_t across = old.next[Index(k)];
  const auto m = static_cast<int32_t>(face_of_.size());
  const auto half = static_cast<int32_t>(faces_.size());  // of this face, on b's side
  const int32_t far_half = across < 0 ? -1 : half + 1;    // of the face across, on a's side
  face_of_.push_back(face);
  faces_.resize(faces_.size() + (across < 0 ? 1 : 2));
  const int32_t beyond_b = old.next[Index(Next(k))];
  Set(face, {{a, m, c}, {far_half, half, old.next[Index(Previous(k))]}});
  Set(half, {{m, b, c}, {across, beyond_b, face}});
  Relink(beyond_b, face, half);
  changed.insert(changed.end(), {face, half});
  if (across >= 0) {
    const Face other = At(across);
    const int j = SideOf(across, b, a);
    assert(j >= 0);
    const int32_t d = other.v[Index(Previous(j))];
    const int32_t beyond_a = other.next[Index(Next(j))];
    Set(across, {{b, m, d}, {half, far_half, other.next[Index(Previous(j))]}});
    Set(far_half, {{m, a, d}, {face, beyond_a, across}});
    Relink(beyond_a, across, far_half);
    changed.insert(changed.end(), {across, far_half});
  }
  return m;
}

void DiscMesh::Flip(int32_t face, int k) {
  const Face old = At(face);
  const int32_t across = old.next[Index(k)];
  const Face other = At(across);
  const int32_t a = old.v[Index(k)];
  const int32_t b = old.v[Index(Next(k))];
  const int32_t c = old.v[Index(Previous(k))];
  const int j = SideOf(across, b, a);
  assert(j >= 0);
  const int32_t d = other.v[Index(Previous(j))];
  const int32_t beyond_ad = other.next[Index(Next(j))];
  const int32_t beyond_bc = old.next[Index(Next(k))];
  Set(face, {{a, d, c}, {beyond_ad, across, old.next[Index(Previous(k))]}});
  Set(across, {{d, b, c}, {other.next[Index(Previous(j))], beyond_bc, face}});
  Relink(beyond_ad, across, face);
  Relink(beyond_bc, face, across);
}

void DiscMesh::FacesAround(int32_t v, std::vector<int32_t>& faces) const {
  const auto side_from = [&](int32_t f) {  // the side that starts at v
    int k = 0;
    while (At(f).v[Index(k)] != v) {
      ++k;
    }
    return k;
  };
  const int32_t start = face_of_[static_cast<size_t>(v)];
  int32_t first = start;  // walk clockwise to the border, or once around
  for (int32_t f = start; f >= 0;) {
    first = f;
    f = At(f).next[Index(side_from(f))];
    if (f == start) {
      first = start;
      break;
    }
  }
  faces.clear();
  int32_t f = first;
  do {
    faces.push_back(f);
    f = At(f).next[Index(Previous(side_from(f)))];
  } while (f >= 0 && f != first);
}

}  // namespace cohort
