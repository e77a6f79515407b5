#pragma once

#include <string>

namespace cohort {

/// Name of a VFS of SQLite (a layer between it and the file system) that keeps a checksum in each
/// page of a database file, and refuses a page that does not have its own: SQLite itself believes
/// whatever a text or a number says, and PRAGMA quick_check sees only what is out of order.
///
/// A page's last 16 bytes, which SQLite leaves alone when asked to (file_control RESERVE_BYTES),
/// hold the first 16 hexadecimal digits of the SHA-256 of the other bytes and the page's number.
/// They are written with each page and verified whenever it is read from the file. Files that begin
/// without such bytes are left as they are. The write-ahead log has checksums of SQLite's own.
/// Costs: 0.4 % of the file, about 5 us a page read or written.
inline constexpr char kChecksumVfs[] = "cohort-checksums";
inline constexpr int kChecksumBytes = 16;

/// Makes kChecksumVfs known to SQLite; each file opened through it uses what is SQLite's default
/// VFS then. May be called often, by several threads.
void RegisterChecksumVfs();

/// What was wrong with the last page that this thread was refused, "page 7 of /data/catalog.db does
/// not have its checksum"; empty if there was none since the last call.
[[nodiscard]] std::string TakePageDamage();

}  // namespace cohort
