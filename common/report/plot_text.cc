#include "common/report/plot_text.h"

#include <algorithm>
#include <cstdint>

#include "common/base/utf8.h"

namespace cohort {
namespace {

constexpr std::string_view kEllipsis = "\xE2\x80\xA6";  // U+2026
constexpr size_t kWorthLeavingOut = 4;                  // Bytes; shorter ones stay.

uint8_t ByteAt(std::string_view text, size_t i) {
  return static_cast<uint8_t>(text[i]);
}

bool IsContinuation(uint8_t byte) {
  return (byte & 0xC0U) == 0x80U;
}

size_t CommonPrefix(std::span<const std::string> labels) {
  std::string_view prefix = labels.front();
  for (const std::string_view label : labels) {
    const auto end = std::mismatch(prefix.begin(), prefix.end(), label.begin(), label.end()).first;
    prefix = prefix.substr(0, static_cast<size_t>(end - prefix.begin()));
  }
  size_t length = prefix.size();
  // Not within a character: the byte after the cut must begin one, in all labels alike.
  while (length > 0 && std::any_of(labels.begin(), labels.end(), [length](const auto& label) {
           return length < label.size() && IsContinuation(ByteAt(label, length));
         })) {
    --length;
  }
  return length;
}

size_t CommonSuffix(std::span<const std::string> labels, size_t prefix) {
  std::string_view suffix = std::string_view(labels.front()).substr(prefix);
  for (const std::string& label : labels) {
    const std::string_view rest = std::string_view(label).substr(prefix);
    const auto end = std::mismatch(suffix.rbegin(), suffix.rend(), rest.rbegin(), rest.rend());
    suffix = suffix.substr(static_cast<size_t>(suffix.rend() - end.first));
  }
  size_t length = suffix.size();
  while (length > 0 && IsContinuation(ByteAt(suffix, suffix.size() - length))) --length;
  return length;
}

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

std::vector<std::string> WithoutCommonEnds(std::vector<std::string> labels) {
  if (labels.size() < 2) return labels;
  const std::string& first = labels.front();
  size_t prefix = CommonPrefix(labels);
  size_t suffix = CommonSuffix(labels, prefix);
  // Numbers stay whole: "…007" rather than "…7" of "007" and "008".
  while (prefix > 0 && IsDigit(first[prefix - 1])) --prefix;
  while (suffix > 0 && IsDigit(first[first.size() - suffix])) --suffix;
  for (std::string& label : labels) {
    if (suffix >= kWorthLeavingOut) label.replace(label.size() - suffix, suffix, kEllipsis);
    if (prefix >= kWorthLeavingOut) label.replace(0, prefix, kEllipsis);
  }
  return labels;
}

std::vector<size_t> CharacterStarts(std::string_view text) {
  std::vector<size_t> starts;
  for (size_t i = 0; i < text.size(); ++i) {
    if (!IsContinuation(ByteAt(text, i))) starts.push_back(i);
  }
  return starts;
}

// Takes characters from the middle until the rest fits; the end keeps one more than the beginning,
// because numbers stand there.
std::string MiddleCut(const std::string& text, double max_width, const MeasureText& width) {
  if (width(text) <= max_width) return text;
  const std::vector<size_t> starts = CharacterStarts(text);
  for (size_t kept = starts.size() - 1; kept > 0; --kept) {
    const size_t head_end = starts[kept / 2];
    const size_t tail_begin = starts[starts.size() - (kept - kept / 2)];
    std::string cut = text.substr(0, head_end);
    cut += kEllipsis;
    cut += text.substr(tail_begin);
    if (width(cut) <= max_width) return cut;
  }
  return std::string(kEllipsis);
}

}  // namespace

std::vector<std::string> FittedLabels(std::span<const std::string> labels,
                                      double max_width,
                                      const MeasureText& width) {
  std::vector<std::string> fitted;
  fitted.reserve(labels.size());
  for (const std::string& label : labels) fitted.push_back(PrintableUtf8(label));
  const bool all_fit = std::all_of(fitted.begin(), fitted.end(), [&](const std::string& label) {
    return width(label) <= max_width;
  });
  if (all_fit) return fitted;
  fitted = WithoutCommonEnds(std::move(fitted));
  for (std::string& label : fitted) label = MiddleCut(label, max_width, width);
  return fitted;
}

}  // namespace cohort
