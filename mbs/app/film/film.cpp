// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/film/film.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <stdexcept>

#include "mbs/app/film/browser.hpp"
#include "mbs/base/files/output.hpp"

namespace flexura::app {
namespace {

using nlohmann::json;

constexpr std::array kFormats = {"mp4", "webm", "gif"};
constexpr std::array kViews = {"+x", "-x", "+y", "-y", "+z", "-z", "iso"};
const std::map<std::string, int> kColors = {{"bodies", 0}, {"displacement", 1}, {"stress", 5}};

std::string format_of(const std::filesystem::path& film) {
  const std::string end = film.extension().string();
  return end.empty() ? end : end.substr(1);
}

/// "1280x720"; {0, 0} where it is none.
std::array<int, 2> size_of(const std::string& text) {
  std::array<int, 2> size{};
  const char *const end = text.data() + text.size(), *middle = std::from_chars(text.data(), end, size[0]).ptr;
  if (middle == end || *middle != 'x' || std::from_chars(middle + 1, end, size[1]).ptr != end) return {};
  return size;
}

std::string from_base64(const std::string& text) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    const auto digit = digits.find(c);
    if (digit == std::string_view::npos) break;  // the padding
    bits = bits << 6 | static_cast<unsigned>(digit);
    if ((held += 6) < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 255U);
  }
  return bytes;
}

}  // namespace

void check_film(const std::filesystem::path& film, const FilmOptions& o) {
  const auto refuse = [](const char* option, const auto& value, const std::string& rule) {
    throw std::invalid_argument(fmt::format("{} is '{}': {}", option, value, rule));
  };
  if (std::ranges::find(kFormats, format_of(film)) == kFormats.end())
    refuse("--film", film.string(), fmt::format("a film ends in .{}", fmt::join(kFormats, ", .")));
  const auto [wide, high] = size_of(o.size);
  // As the page has them (film_dialog.ts).
  if (std::min(wide, high) < 64 || std::max(wide, high) > 4096)
    refuse("--film-size", o.size, "write width and height, 64 to 4096 pixels each, as 1280x720");
  if (std::ranges::find(kViews, o.view) == kViews.end())
    refuse("--film-view", o.view, fmt::format("it is one of {}", fmt::join(kViews, ", ")));
  if (!o.color.empty() && !kColors.contains(o.color))
    refuse("--film-color", o.color, "it is one of bodies, displacement, stress");
  if (o.fps < 1 || o.fps > 60) refuse("--film-fps", o.fps, "frames per second are 1 to 60");
  if (o.seconds != 0.0 && !(o.seconds > 0.0 && o.seconds * o.fps <= 6000.0))
    refuse("--film-seconds", o.seconds, "a film has 1 to 6000 frames, with --film-fps of them in a second");
}

void write_film(const std::filesystem::path& film, const std::filesystem::path& html, const FilmOptions& o) {
  Browser browser(find_browser(), 1400, 900);
  browser.open(html);
  const auto [wide, high] = size_of(o.size);
  json wish = {{"format", format_of(film)}, {"width", wide}, {"height", high}, {"fps", o.fps}};
  // The page writes minus signs.
  wish["view"] = o.view.starts_with('-') ? "\u2212" + o.view.substr(1) : o.view;
  if (o.seconds > 0.0) wish["seconds"] = o.seconds;
  if (!o.color.empty()) {
    if (o.color == "stress" && browser.evaluate("flexura.largestStress") == 0)
      throw std::invalid_argument(
          "--film-color is 'stress': no body of these results has stresses to colour; give the body stress = "
          "true "
          "and its part [recovery] stress = true");
    browser.evaluate(fmt::format("flexura.setField({})", kColors.at(o.color)));
  }
  const json text = browser.evaluate(fmt::format("flexura.film({})", wish.dump()));
  if (!text.is_string())
    throw std::runtime_error(
        "the browser gave no film of this page; try it again, or make the film on the page itself");
  files::write_whole(film, from_base64(text.get<std::string>()));
}

}  // namespace flexura::app
