#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>

namespace cohort {

struct ServerOptions {
  std::string data_dir = "cohort-data";  ///< Catalog and blobs.
  std::string catalog;  ///< Location as Catalog::Open takes it; empty: catalog.db in data_dir.
  std::vector<std::string> listen = {
      "127.0.0.1:7450"};  ///< HOST:PORT (port 0: a free one), unix:PATH.
  double lease_seconds = 60;
  std::string port_file;       ///< If set, the addresses listened on are written there, one a line.
  std::string metrics_listen;  ///< HOST:PORT of http://HOST:PORT/metrics; empty: none.
  std::string log_level = "info";
  /// The server ends when this process (its parent) does; 0: it does not look.
  int exit_with_parent = 0;

  double gc_age_hours = 24;      ///< GarbageOptions::age_seconds.
  double gc_remember_days = 90;  ///< GarbageOptions::remember_seconds.
  double min_free_gb = 1;        ///< StoreReserve::bytes, in 10^9.
  double min_free_percent = 5;   ///< StoreReserve::share.

  /// Where the catalog is.
  [[nodiscard]] std::string CatalogLocation() const {
    return catalog.empty() ? data_dir + "/catalog.db" : catalog;
  }

  /// @return kInvalidArgument naming the option.
  [[nodiscard]] absl::Status Validate() const;
};

}  // namespace cohort
