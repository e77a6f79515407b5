#pragma once

#include <cstddef>
#include <vector>

namespace cohort {

/// From this size on, scratch memory lies in a file.
inline constexpr size_t kScratchFileBytes = size_t{256} << 20;

/// Memory for what may be larger than the machine's: from kScratchFileBytes on it is a mapped file
/// without a name in the folder for temporary files ($TMPDIR, or /tmp), so that the system can put
/// it aside and take it back; ordinary memory below, and where there is no room for the file.
/// Throws std::bad_alloc. Thread-safe.
[[nodiscard]] void* AllocateScratch(size_t bytes);
/// @param bytes  as given to AllocateScratch.
void FreeScratch(void* memory, size_t bytes) noexcept;

/// Gives scratch memory to a container of the standard library.
template <typename T>
class ScratchAllocator {
 public:
  using value_type = T;

  ScratchAllocator() = default;
  template <typename U>
  explicit ScratchAllocator(const ScratchAllocator<U>& /*other*/) {}

  [[nodiscard]] T* allocate(size_t count) {
    return static_cast<T*>(AllocateScratch(count * sizeof(T)));
  }
  void deallocate(T* memory, size_t count) noexcept { FreeScratch(memory, count * sizeof(T)); }

  friend bool operator==(const ScratchAllocator& /*a*/, const ScratchAllocator& /*b*/) {
    return true;
  }
};

/// Reserve before it grows: while it moves, both places take room.
template <typename T>
using ScratchVector = std::vector<T, ScratchAllocator<T>>;

}  // namespace cohort
