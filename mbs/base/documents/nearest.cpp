// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/shown_text.hpp"

namespace flexura::input {
namespace {

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

// Optimal string alignment distance: insertion, deletion, substitution and exchange of neighbours cost 2, a
// letter in the wrong case costs 1, so that "Mpa" is nearer to "MPa" than to "kPa".
int edit_cost(const std::string& a, const std::string& b) {
  const std::size_t n = a.size(), m = b.size();
  std::vector<std::vector<int>> cost(n + 1, std::vector<int>(m + 1));
  for (std::size_t i = 0; i <= n; ++i) cost[i][0] = 2 * static_cast<int>(i);
  for (std::size_t j = 0; j <= m; ++j) cost[0][j] = 2 * static_cast<int>(j);
  for (std::size_t i = 1; i <= n; ++i) {
    for (std::size_t j = 1; j <= m; ++j) {
      const int change = a[i - 1] == b[j - 1] ? 0 : lower(a[i - 1]) == lower(b[j - 1]) ? 1 : 2;
      cost[i][j] = std::min({cost[i - 1][j] + 2, cost[i][j - 1] + 2, cost[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1])) {
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 2);
      }
    }
  }
  return cost[n][m];
}

constexpr int longest_word = 200;

bool abbreviates(const std::string& shorter, const std::string& longer) {
  return shorter.size() >= 3 && longer.size() > shorter.size() && longer.starts_with(shorter);
}

}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  int best_cost = 0;
  for (const std::string& candidate : known) {
    const auto length = static_cast<int>(std::max(word.size(), candidate.size()));
    // One slip in a short word, one in three letters of a long one; a word of one letter only in the wrong
    // case.
    const int allowed = length == 1 ? 1 : 2 * std::max(1, length / 3);
    // Letters that one of them has more cost 2 each: no need to look at two long words of unlike length, nor
    // at those that nobody has typed.
    const int more = 2 * std::abs(static_cast<int>(word.size()) - static_cast<int>(candidate.size()));
    int cost = more > allowed || length > longest_word ? allowed + 1 : edit_cost(word, candidate);
    if (cost > allowed && (abbreviates(word, candidate) || abbreviates(candidate, word))) cost = allowed;
    if (cost <= allowed && (best.empty() || cost < best_cost)) {
      best = candidate;
      best_cost = cost;
    }
  }
  return best;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
  if (const std::string near = nearest(word, known); !near.empty())
    return ", did you mean \"" + shown_text(near) + "\"?";
  if (known.empty()) return "";
  std::string text = "; known are ";
  constexpr std::size_t most = 20, longest = 220;
  std::size_t n = 0;
  for (; n < std::min(known.size(), most) && text.size() < longest; ++n)
    text += (n ? ", " : "") + shown_text(known[n]);
  if (known.size() > n) text += " and " + std::to_string(known.size() - n) + " more";
  return text;
}

}  // namespace flexura::input
