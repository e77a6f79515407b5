#include "common/jobs/worker_build.h"

#include <absl/strings/str_cat.h>

#include "common/base/version.h"
#include "common/jobs/action_key.h"

namespace cohort {

std::string WorkerBuild() {
  return absl::StrCat(std::string(BuildVersion()), " (results ", kResultsVersion, ")");
}

}  // namespace cohort
