#pragma once

#include <string_view>

namespace cohort {

/// Version of this build, e.g. "0.1.0"; server and workers must have the same one.
[[nodiscard]] std::string_view BuildVersion();

}  // namespace cohort
