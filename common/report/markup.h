#pragma once

#include <string>
#include <string_view>

namespace cohort {

/// Foreign text for HTML and SVG, between tags and in quoted attributes: & < > " ' as entities, and
/// what no page can hold (control characters, bytes that are not UTF-8) as U+FFFD.
[[nodiscard]] std::string EscapeMarkup(std::string_view text);

/// Base64 with padding. Source: RFC 4648 section 4.
[[nodiscard]] std::string Base64(std::string_view bytes);

}  // namespace cohort
