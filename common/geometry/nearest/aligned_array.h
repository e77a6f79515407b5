#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace cohort {

/// Numbers at an address that a cache line begins at, as vector instructions want them.
template <typename T>
class AlignedArray {
 public:
  AlignedArray() = default;
  /// `size` numbers of no defined value.
  explicit AlignedArray(size_t size) { Reset(size); }

  /// Makes room for `size` numbers of no defined value; the memory is kept if it is enough.
  void Reset(size_t size) {
    constexpr size_t kCacheLine = 64;
    if (size > capacity_) {
      const size_t bytes = (size * sizeof(T) + kCacheLine - 1) / kCacheLine * kCacheLine;
      memory_.reset(static_cast<T*>(std::aligned_alloc(kCacheLine, bytes)));
      if (memory_ == nullptr) {
        throw std::bad_alloc();
      }
      capacity_ = size;
    }
    size_ = size;
  }
  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] T* data() { return memory_.get(); }
  [[nodiscard]] const T* data() const { return memory_.get(); }
  [[nodiscard]] T& operator[](size_t i) { return memory_[i]; }
  [[nodiscard]] const T& operator[](size_t i) const { return memory_[i]; }

 private:
  struct Free {
    void operator()(T* memory) const { std::free(memory); }
  };
  std::unique_ptr<T[], Free> memory_;
  size_t size_ = 0;
  size_t capacity_ = 0;
};

}  // namespace cohort
