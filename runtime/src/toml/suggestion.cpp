#include "driveline/runtime/toml/suggestion.hpp"

#include <algorithm>
#include <vector>

namespace driveline::runtime {
namespace {

/// Returns the number of letters to insert, omit, replace, or swap with their neighbour (optimal string alignment).
std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::string begins_with(std::string_view word, std::span<const std::string_view> known) {
  constexpr std::size_t kShortest = 2;
  if (word.size() < kShortest) return {};
  std::string only;
  for (const auto& name : known) {
    if (!name.starts_with(word)) continue;
    if (!only.empty()) return {};
    only = name;
  }
  return only;
}

}  // namespace

std::string closest(std::string_view word, std::span<const std::string_view> known) {
  // Limits the time of the comparison, which is quadratic.
  constexpr std::size_t kLongest = 40;
  if (word.size() > kLongest) return {};
  std::string best;
  // At most two edits, and at most a third of the letters; with more edits it is another word.
  std::size_t fewest = std::min<std::size_t>(2, word.size() / 3) + 1;
  for (const auto& name : known) {
    const auto edits = edits_between(word, name);
    if (edits >= fewest) continue;
    fewest = edits;
    best = name;
  }
  return best.empty() ? begins_with(word, known) : best;
}

}  // namespace driveline::runtime
