#pragma once

#include <cerrno>

namespace cohort::testing {

/// Makes the disk fail under SQLite: in this thread, the writes, truncations and syncs of files
/// (pwrite64, ftruncate64, fdatasync, fsync: defined in disk_faults_test.cc in place of the C
/// library's) are counted, and one of them, or all from that one on, return an error.
class DiskFaults {
 public:
  enum class Which { kOne, kAllFrom };
  static constexpr int kNone = -1;

  /// @param number  of the operation that fails, from 0; kNone: they are only counted.
  /// @param error_number  EIO, ENOSPC, ...
  DiskFaults(int number, Which which, int error_number);
  ~DiskFaults();
  DiskFaults(const DiskFaults&) = delete;
  DiskFaults& operator=(const DiskFaults&) = delete;

  /// How many operations failed so far.
  [[nodiscard]] int Failed() const;
  /// How many syncs there were so far, good or not.
  [[nodiscard]] int Syncs() const;
};

}  // namespace cohort::testing
