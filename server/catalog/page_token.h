#pragma once

#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace cohort {

/// Which listing a token is of: one listing's token means nothing to another.
enum class Listing : char { kSets = 's', kMeshes = 'm', kJobs = 'j' };

/// A token for the page after the item `key`: letters, digits, '-' and '_'.
[[nodiscard]] std::string MakePageToken(Listing listing, std::string_view key);

/// The key in a token; empty for the empty token, which is the first page.
/// @return kInvalidArgument if `token` is not one of this listing.
[[nodiscard]] absl::StatusOr<std::string> ReadPageToken(Listing listing, const std::string& token);

/// @return kInvalidArgument unless `page_size` >= 1.
[[nodiscard]] absl::Status CheckPageSize(int page_size);

}  // namespace cohort
