#pragma once

#include <filesystem>
#include <string>

#include <absl/status/status.h>

namespace cohort {

/// Copies a catalog into a new file that is a catalog itself, while a server goes on writing: the
/// copy has all that was acknowledged before this began, and no half of a transaction. Written
/// aside in the folder of `to`, verified, on disk before it has its name. Needs room for one copy;
/// while it reads, SQLite's write-ahead log grows.
/// @param location  as Catalog::Open takes it.
/// @param to  the new file; an existing one is never overwritten.
/// @return kNotFound if there is no catalog; kAlreadyExists; kInvalidArgument for PostgreSQL, whose
///         own tools do this, naming them; kDataLoss if the catalog is damaged or not ours; else as
///         Catalog's, or as absl::ErrnoToStatus for `to`.
[[nodiscard]] absl::Status BackUpCatalog(const std::string& location,
                                         const std::filesystem::path& to);

}  // namespace cohort
