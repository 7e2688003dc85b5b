// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_cards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>

#include "mesh/import/deck_files.hpp"

namespace flexura::mesh {
namespace {

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string_view::npos ? "" : std::string(text.substr(first, last - first + 1));
}

std::string expand_tabs(const std::string& line) {
  std::string out;
  for (const char c : line) {
    if (c != '\t')
      out += c;
    else
      out.append(8 - out.size() % 8, ' ');
  }
  return out;
}

std::optional<double> parse_real(const std::string& field) {
  std::string text;
  for (std::size_t k = 0; k < field.size(); ++k) {
    const char c = field[k];
    const bool sign = c == '+' || c == '-';
    const bool after_exponent = !text.empty() && text.back() == 'e';
    if (sign && k > 0 && !after_exponent) text += 'e';  // "1.5+5" means 1.5e5
    if (c == 'd' || c == 'D' || c == 'e' || c == 'E')
      text += 'e';
    else if (c != '+')
      text += c;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

/// One physical line: the name field and 8 (small, free) or 4 (large) data fields.
struct Line {
  std::string name;
  std::vector<std::string> fields;
  std::string next;  ///< the mark of the line that goes on with the card
};

// "+AB", "*AB" and "AB" are one mark; "+" alone is none.
std::string mark(const std::string& text) {
  return upper(trimmed(std::string_view(text).substr(
      text.find_first_not_of("+*") == std::string::npos ? text.size() : text.find_first_not_of("+*"))));
}

Line split_line(const std::string& raw) {
  Line line;
  // A comma among the first ten characters makes it free; behind fixed fields there may be words with some.
  const std::size_t start = std::min(raw.find_first_not_of(" \t"), raw.size());
  const bool named = start < raw.size() && std::isalpha(static_cast<unsigned char>(raw[start]));
  if (raw.find(',') < 10 + (named ? start : 0)) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0;;) {
      const std::size_t comma = raw.find(',', begin);
      parts.push_back(trimmed(std::string_view(raw).substr(begin, comma - begin)));
      if (comma == std::string::npos) break;
      begin = comma + 1;
    }
    line.name = parts[0];
    const std::size_t width = !line.name.empty() && line.name.back() == '*' ? 4 : 8;
    // After the last field of a line stands the name of its continuation.  What stands there and is none (a number, or
    // anything with more behind it) goes on with the card: some programs write it all on one line.
    std::size_t n = parts.size();
    while (n > 1 && parts[n - 1].empty()) --n;
    const auto is_name = [](const std::string& text) {
      return text.empty() || text[0] == '*' || std::isalpha(static_cast<unsigned char>(text[0])) ||
             text[0] == '+';
    };
    if (n == width + 2 && is_name(parts[width + 1])) line.next = mark(parts[width + 1]);
    if (n <= width + 1 || (n == width + 2 && is_name(parts[width + 1]))) n = width + 1;
    parts.resize(std::max(n, width + 1));
    line.fields.assign(parts.begin() + 1, parts.end());
    return line;
  }
  const std::string text = expand_tabs(raw);
  line.name = trimmed(std::string_view(text).substr(0, 8));
  const bool large = line.name.find('*') != std::string::npos;
  const std::size_t width = large ? 16 : 8;
  for (std::size_t k = 0; k < (large ? 4 : 8); ++k) {
    const std::size_t begin = 8 + k * width;
    line.fields.push_back(begin < text.size() ? trimmed(std::string_view(text).substr(begin, width)) : "");
  }
  if (text.size() > 72) line.next = mark(trimmed(std::string_view(text).substr(72, 8)));
  return line;
}

class Deck {
 public:
  explicit Deck(std::set<std::string>& names) : files_(names, "INCLUDE") {}

  void read(const std::filesystem::path& path, bool skip_case_control, int depth) {
    std::ifstream file = files_.open(path, depth);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line.substr(0, line.find('$')));
    std::size_t first = 0;
    const std::string* name = files_.name(path);
    for (std::size_t k = 0; skip_case_control && k < lines.size(); ++k) {
      const std::string text = upper(trimmed(lines[k]));
      if (text.rfind("ENDDATA", 0) == 0) break;
      if (text.rfind("BEGIN", 0) != 0) continue;
      if (first > 0)
        throw std::invalid_argument(
            fmt::format("{}: a second section of bulk data ({}); the first begins in line {}: write each "
                        "superelement or module to a file of its own",
                        Where{name, static_cast<int>(k) + 1}.text(), text.substr(0, 40), first));
      first = k + 1;
    }
    for (std::size_t k = first; k < lines.size() && !ended_; ++k)
      take(lines[k], {name, static_cast<int>(k) + 1}, path, depth);
  }
  std::vector<Card> cards;

 private:
  void take(const std::string& given, const Where& where, const std::filesystem::path& path, int depth) {
    const std::string raw = plain_line(given, where);
    if (trimmed(raw).empty()) return;
    if (upper(trimmed(raw)).rfind("ENDDATA", 0) == 0) {
      ended_ = true;
      return;
    }
    if (upper(trimmed(raw)).rfind("INCLUDE", 0) == 0) {
      including_ = trimmed(trimmed(raw).substr(7));
      if (including_.empty()) including_ = "'";
    } else if (!including_.empty()) {
      including_ += trimmed(raw);
      constexpr std::size_t longest = 10'000;  // as paths are
      if (including_.size() > longest)
        throw std::invalid_argument(fmt::format(
            "{}: the name of an INCLUDE has more than {} letters; close its quotes", where.text(), longest));
    }
    if (!including_.empty()) {  // a name in quotes may go on over several lines
      const char quote = including_[0];
      const bool quoted = quote == '\'' || quote == '"';
      if (quoted && including_.find(quote, 1) == std::string::npos) return;
      std::string file = quoted ? including_.substr(1, including_.find(quote, 1) - 1) : including_;
      including_.clear();
      std::ranges::replace(file, '\\', '/');
      read(path.parent_path() / file, false, depth + 1);
      return;
    }
    Line line = split_line(raw);
    for (std::string& field : line.fields) field = upper(std::move(field));
    const bool continues = line.name.empty() || line.name[0] == '+' || line.name[0] == '*';
    if (!continues) {
      Card card;
      card.name = upper(line.name);
      card.name.erase(std::remove(card.name.begin(), card.name.end(), '*'), card.name.end());
      card.fields = line.fields;
      card.where = where;
      cards.push_back(std::move(card));
      going_on(cards.size() - 1, line);
      return;
    }
    if (cards.empty())
      throw std::invalid_argument(where.text() + ": a continuation line without a card before it");
    // Where the line before waits for another one, its card is the one that waits for this.
    std::size_t of = cards.size() - 1;
    if (const std::string own = mark(line.name); !own.empty() && own != awaited_)
      if (const auto waiting = waiting_.find(own); waiting != waiting_.end()) of = waiting->second;
    going_on(of, line);
    std::vector<std::string>& fields = cards[of].fields;
    if (line.fields.size() >= 8 && fields.size() % 8 != 0) fields.resize((fields.size() / 8 + 1) * 8);
    fields.insert(fields.end(), line.fields.begin(), line.fields.end());
  }

  void going_on(std::size_t card, const Line& line) {
    awaited_ = line.next;
    if (!line.next.empty()) waiting_[line.next] = card;
  }

  DeckFiles files_;
  bool ended_ = false;
  std::string awaited_;                         // by the last line
  std::map<std::string, std::size_t> waiting_;  // cards by the marks of their next lines
  std::string including_;                       // the name of a file that goes on
};

}  // namespace

const std::string& Card::text(std::size_t k) const {
  static const std::string none;
  return k < fields.size() ? fields[k] : none;
}

std::int64_t Card::integer(std::size_t k) const {
  const std::string& field = text(k);
  std::int64_t value = 0;
  const char* begin = field.data() + (!field.empty() && field[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, field.data() + field.size(), value);
  if (field.empty() || error != std::errc() || end != field.data() + field.size())
    throw std::invalid_argument(fmt::format("{}: field {} of {} is \"{}\" where a whole number is wanted",
                                            where.text(), k + 2, name.substr(0, 20), field.substr(0, 40)));
  return value;
}

std::int64_t Card::integer(std::size_t k, std::int64_t otherwise) const {
  return blank(k) ? otherwise : integer(k);
}

double Card::real(std::size_t k) const {
  const auto value = parse_real(text(k));
  if (!value || !std::isfinite(*value))
    throw std::invalid_argument(fmt::format("{}: field {} of {} is \"{}\" where a number is wanted",
                                            where.text(), k + 2, name.substr(0, 20), text(k).substr(0, 40)));
  return *value;
}

double Card::real(std::size_t k, double otherwise) const {
  return blank(k) ? otherwise : real(k);
}

bool Card::is_real(std::size_t k) const {
  return text(k).find('.') != std::string::npos && parse_real(text(k)).has_value();
}

std::vector<std::string> case_control(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    std::string text;
    for (const char c : line.substr(0, line.find('$')))
      if (!std::isspace(static_cast<unsigned char>(c)))
        text += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (text.rfind("BEGIN", 0) == 0) return lines;
    if (!text.empty()) lines.push_back(std::move(text));
  }
  return {};
}

std::vector<Card> read_cards(const std::filesystem::path& path, std::set<std::string>& names) {
  Deck deck(names);
  deck.read(path, true, 0);
  return std::move(deck.cards);
}

}  // namespace flexura::mesh
