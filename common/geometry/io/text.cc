#include "common/geometry/io/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

constexpr size_t kLongestQuote = 40;

bool IsBlank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

/// from_chars knows "-" but not "+", and must not see "+-1" as a number.
bool DropPlus(std::string_view& word) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    return !word.starts_with('-') && !word.starts_with('+');
  }
  return true;
}

/// Of a number that from_chars could not hold: was it too small rather than too large?
bool Underflows(std::string_view word) {
  const size_t exponent = word.find_first_of("eE");
  if (exponent != std::string_view::npos) {
    return word.substr(exponent + 1).starts_with('-');
  }
  const std::string_view whole = word.substr(0, word.find('.'));
  return whole.find_first_of("123456789") == std::string_view::npos;
}

absl::Status Error(std::string_view file, const std::string& place, std::string_view reason) {
  return absl::InvalidArgumentError(std::string(file) + ": " + place + std::string(reason));
}

}  // namespace

bool LineReader::Next(std::string_view& line) {
  if (offset_ >= text_.size()) {
    return false;
  }
  const char* const begin = text_.data() + offset_;
  const char* const text_end = text_.data() + text_.size();
  const char* end = begin;
  while (end != text_end && *end != '\n' && *end != '\r') {
    ++end;
  }
  line = std::string_view(begin, static_cast<size_t>(end - begin));
  offset_ += line.size();
  if (end != text_end) {
    offset_ += *end == '\r' && end + 1 != text_end && end[1] == '\n' ? 2 : 1;
  }
  ++line_number_;
  return true;
}

std::string_view NextWord(std::string_view& rest) {
  const auto* const begin =
      std::find_if(rest.begin(), rest.end(), [](char c) { return !IsBlank(c); });
  const auto* const end = std::find_if(begin, rest.end(), IsBlank);
  const std::string_view word(begin, static_cast<size_t>(end - begin));
  rest.remove_prefix(static_cast<size_t>(end - rest.begin()));
  return word;
}

bool ParseNumber(std::string_view word, double& value) {
  if (!DropPlus(word)) {
    return false;
  }
  const char* const end = word.data() + word.size();
  const auto [parsed_to, error] = std::from_chars(word.data(), end, value);
  if (parsed_to != end) {
    return false;
  }
  if (error == std::errc::result_out_of_range && Underflows(word)) {
    value = 0;
    return true;
  }
  return error == std::errc() && std::isfinite(value);
}

bool ParseInteger(std::string_view word, int64_t& value) {
  if (!DropPlus(word)) {
    return false;
  }
  const char* const end = word.data() + word.size();
  const auto [parsed_to, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && parsed_to == end;
}

bool EqualIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return absl::ascii_tolower(static_cast<unsigned char>(x)) ==
           absl::ascii_tolower(static_cast<unsigned char>(y));
  });
}

std::string Quoted(std::string_view word) {
  const std::string shown(word.substr(0, kLongestQuote));
  return absl::StrCat("'", absl::CHexEscape(shown), word.size() > kLongestQuote ? "..." : "", "'");
}

absl::Status LineError(std::string_view file, int64_t line, std::string_view reason) {
  return Error(file, absl::StrCat("line ", line, ": "), reason);
}

absl::Status ByteError(std::string_view file, size_t offset, std::string_view reason) {
  return Error(file, absl::StrCat("byte ", offset, ": "), reason);
}

absl::Status FileError(std::string_view file, std::string_view reason) {
  return Error(file, "", reason);
}

}  // namespace cohort
