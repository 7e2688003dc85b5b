// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/terminal/terminal.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "mbs/base/files/plain_text.hpp"
#include "mbs/base/terminal/harmless_stream.hpp"
#include "mbs/base/terminal/sequences.hpp"

namespace flexura::terminal {
namespace {

std::string padded(const std::string& text, int width, Align align) {
  const auto room = static_cast<std::size_t>(std::max(0, width - display_width(text)));
  return align == Align::right ? std::string(room, ' ') + text : text + std::string(room, ' ');
}

// The first `width` columns, the last of them "…" when something is cut off.
std::string shortened(const std::string& text, int width) {
  if (display_width(text) <= width) return text;
  std::size_t at = 0;
  for (int column = 0; column < width - 1; ++column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80) ++at;
  }
  return text.substr(0, at) + "…";
}

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool is_terminal(std::FILE* stream) {
  const char* term = std::getenv("TERM");
  return ::isatty(descriptor_of(stream)) == 1 && !(term && std::strcmp(term, "dumb") == 0);
}

// What is put between the sequences of ours, which pass: nothing of it is one.
std::string harmless(std::string_view text) {
  return files::harmless_text(text, files::LineFeeds::kept);
}

// A terminal that has gone (SIGHUP) is no reason to lose a run.
void put(std::FILE* stream, const std::string& text) {
  std::fputs(text.c_str(), stream);
}

}  // namespace

bool takes_colour(std::FILE* stream) {
  const char* refused = std::getenv("NO_COLOR");
  return !(refused && *refused) && is_terminal(stream);
}

int width(std::FILE* stream) {
  winsize size{};
  if (::ioctl(descriptor_of(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  const char* columns = std::getenv("COLUMNS");
  const int given = columns ? std::atoi(columns) : 0;
  return given > 0 ? given : 80;
}

std::string folded(const std::string& sentence, int width, int indent) {
  std::string out, line;
  for (std::size_t at = 0; at < sentence.size();) {
    std::size_t end = sentence.find(' ', at + 1);
    if (end == std::string::npos) end = sentence.size();
    std::string word = sentence.substr(at, end - at);  // with the blank before it
    if (!line.empty() && display_width(line) + display_width(word) > width) {
      out += line + "\n";
      line = std::string(static_cast<std::size_t>(indent), ' ');
      word.erase(0, word.find_first_not_of(' '));
    }
    line += word;
    at = end;
  }
  return out + line;
}

int takes_columns(std::FILE* stream) {
  return ::isatty(descriptor_of(stream)) == 1 || std::getenv("COLUMNS") ? width(stream)
                                                                        : std::numeric_limits<int>::max();
}

void say(std::FILE* stream, const std::string& sentence) {
  put(stream, folded(harmless(sentence), takes_columns(stream)) + "\n");
}

int display_width(std::string_view text) {
  return static_cast<int>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string number(double value, int digits) {
  if (value == 0.0) return "0";  // not "-0"
  return fmt::format("{:.{}g}", value, digits);
}

std::string duration(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string bytes(double count) {
  static const char* const units[] = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (count >= 999.5 && unit + 1 < std::size(units)) {
    count /= 1000.0;
    ++unit;
  }
  return unit == 0 ? fmt::format("{:.0f} B", count) : fmt::format("{:.3g} {}", count, units[unit]);
}

std::string bold(std::string_view text, bool colour) {
  return colour ? fmt::format("{}{}{}", kBold, harmless(text), kPlain) : harmless(text);
}
std::string red(std::string_view text, bool colour) {
  return colour ? fmt::format("{}{}{}", kRed, harmless(text), kPlain) : harmless(text);
}

// --- Table -----------------------------------------------------------------------------------------------

void Table::add_row(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  for (std::string& cell : cells)
    if (!files::is_plain_text(cell)) cell = files::plain_text(cell);
  rows_.push_back(std::move(cells));
}

namespace {

constexpr int column_gap = 2;

}  // namespace

int Table::total(const std::vector<std::size_t>& columns, const std::vector<int>& widths) {
  int sum = columns.empty() ? 0 : -column_gap;
  for (const std::size_t c : columns) sum += widths[c] + column_gap;
  return sum;
}

std::string Table::block(const std::vector<std::size_t>& columns, const std::vector<int>& widths,
                         bool colour) const {
  std::string out;
  const auto add_line = [&](const auto& cell, bool heading) {
    std::string line;
    for (const std::size_t c : columns) {
      if (c != columns.front()) line += std::string(column_gap, ' ');
      line += padded(shortened(cell(c), widths[c]), widths[c], columns_[c].align);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += (heading ? bold(line, colour) : line) + "\n";
  };
  add_line([&](std::size_t c) { return columns_[c].heading; }, true);
  out += std::string(static_cast<std::size_t>(std::max(total(columns, widths), 0)), '-') + "\n";
  for (const auto& row : rows_) add_line([&](std::size_t c) { return row[c]; }, false);
  return out;
}

std::string Table::text(int width, bool colour) const {
  const std::size_t n = columns_.size();
  constexpr int narrowest = 8;
  std::vector<int> widths(n);
  std::vector<std::size_t> all(n);
  for (std::size_t c = 0; c < n; ++c) {
    all[c] = c;
    widths[c] = display_width(columns_[c].heading);
    for (const auto& row : rows_) widths[c] = std::max(widths[c], display_width(row[c]));
  }
  // What names a row must stay a name.
  const auto least = [&](std::size_t c) {
    return c < repeated_ ? std::max(narrowest, width / 3) : narrowest;
  };
  // What the columns of numbers leave is shared by those of words, as long as each keeps something to read.
  const auto shorten = [&](const std::vector<std::size_t>& columns) {
    while (total(columns, widths) > width) {
      std::size_t widest = n;
      for (const std::size_t c : columns) {
        if (columns_[c].align == Align::left && widths[c] > least(c) &&
            (widest == n || widths[c] > widths[widest])) {
          widest = c;
        }
      }
      if (widest == n) return false;
      --widths[widest];
    }
    return true;
  };
  const std::vector<int> wished = widths;
  if (shorten(all)) return block(all, widths, colour);

  // Still too wide: several tables below one another, each with the first columns again.
  widths = wished;
  std::vector<std::size_t> first(std::min(repeated_, n));
  for (std::size_t c = 0; c < first.size(); ++c) first[c] = c;
  for (std::size_t c : first) widths[c] = std::min(widths[c], least(c));
  std::string out;
  std::vector<std::size_t> columns = first;
  const auto close = [&] {
    shorten(columns);
    out += (out.empty() ? "" : "\n") + block(columns, widths, colour);
    columns = first;
  };
  for (std::size_t c = first.size(); c < n; ++c) {
    columns.push_back(c);
    if (total(columns, widths) <= width || columns.size() == first.size() + 1) continue;
    columns.pop_back();
    close();
    columns.push_back(c);
  }
  close();
  return out;
}

// --- Progress --------------------------------------------------------------------------------------------

Progress::Progress(std::FILE* stream, bool quiet, bool verbose)
    : Progress(stream, quiet, is_terminal(stream), steady_seconds, verbose) {}

Progress::Progress(std::FILE* stream, bool quiet, bool is_terminal, Clock clock, bool verbose)
    : stream_(stream),
      quiet_(quiet || !(is_terminal || verbose)),
      draws_(is_terminal),
      clock_(std::move(clock)) {}

Progress::~Progress() {
  clear();
}

void Progress::operator()(std::string_view given, double fraction) {
  if (quiet_) return;
  const std::string stage = files::plain_text(given);
  const double now = clock_();
  if (stage != stage_) {
    end_stage();
    stage_ = stage;
    start_ = now;
    last_drawn_ = -1.0;
  }
  if (draws_ && (last_drawn_ < 0.0 || now - last_drawn_ >= 0.1)) draw(fraction, now);
}

void Progress::draw(double fraction, double now) {
  constexpr int bar = 24;
  const double elapsed = now - start_;
  std::string line = shortened(stage_, 28);
  if (fraction >= 0.0) {
    fraction = std::min(fraction, 1.0);
    const auto filled = static_cast<std::size_t>(std::lround(fraction * bar));
    line += fmt::format("  [{}{}] {:3.0f} %  {}", std::string(filled, '#'), std::string(bar - filled, ' '),
                        100.0 * fraction, duration(elapsed));
    // A forecast from the first percent of a task is noise.
    if (fraction > 0.01 && fraction < 1.0 && elapsed > 0.5) {
      line += fmt::format(", {} left", duration(elapsed * (1.0 - fraction) / fraction));
    }
  } else {
    line += "  " + duration(elapsed);
  }
  put(stream_, std::string(kClearLine) + shortened(line, 79));
  std::fflush(stream_);
  drawn_ = true;
  last_drawn_ = now;
}

void Progress::clear() {
  if (!drawn_) return;
  put(stream_, std::string(kClearLine));
  std::fflush(stream_);
  drawn_ = false;
}

void Progress::end_stage() {
  if (stage_.empty()) return;
  clear();
  put(stream_, fmt::format("{}: {}\n", stage_, duration(clock_() - start_)));
  std::fflush(stream_);
  stage_.clear();
}

void Progress::finish() {
  if (!quiet_) end_stage();
}

}  // namespace flexura::terminal
