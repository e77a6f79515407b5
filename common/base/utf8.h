#pragma once

#include <string>
#include <string_view>

namespace cohort {

/// True if `text` is well-formed UTF-8; what JSON, protobuf and our tables can hold.
/// Source: RFC 3629 (no overlong forms, no surrogates, up to U+10FFFF).
[[nodiscard]] bool IsValidUtf8(std::string_view text);

/// `text` with each byte that is not UTF-8 and each control character (C0, DEL, C1) replaced by
/// U+FFFD, so that any file name or quoted byte can be drawn and put into JSON.
[[nodiscard]] std::string PrintableUtf8(std::string_view text);

}  // namespace cohort
