// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/page_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/view/resources.hpp"

namespace flexura::view {

namespace {

std::string escape_html(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

/// Inside a script element only "<" can end it or open a comment: JSON has another spelling for it.
std::string escape_script(std::string text) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      result += "\\u003c";
    } else {
      result += c;
    }
  }
  return result;
}

// The policy forbids the page to load anything at all: what it shows is inside.
constexpr std::string_view head = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="flexura">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:">
<title>)";

}  // namespace

PageFile::PageFile(const std::filesystem::path& path, std::string_view title)
    : path_(path), part_(path.string() + ".part"), out_(part_, std::ios::binary | std::ios::trunc) {
  if (!out_) {
    throw std::runtime_error(
        fmt::format("cannot write the page '{}': {}", path_.string(), std::strerror(errno)));
  }
  put(head);
  put(escape_html(title));
  put("</title>\n<style>\n");
  put(page_style());
  put("</style>\n</head>\n<body>\n<div id=\"app\"><p class=\"loading\">Loading " + escape_html(title) +
      " ...</p></div>\n<noscript>This page draws with JavaScript and WebGL; allow scripts for "
      "it.</noscript>\n");
}

PageFile::~PageFile() {
  if (finished_) return;
  out_.close();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void PageFile::add_block(std::string_view name, std::string_view type, std::string_view base64) {
  put(fmt::format("<script type=\"text/plain\" data-block=\"{}\" data-type=\"{}\">", escape_html(name),
                  type));
  put(base64);
  put("</script>\n");
}

void PageFile::finish(const nlohmann::json& header) {
  put("<script type=\"application/json\" id=\"header\">");
  // Names may hold anything a file system allows: bytes that are not UTF-8 become replacement characters.
  put(escape_script(header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
  put("</script>\n<script>\n");
  put(page_script());
  put("</script>\n</body>\n</html>\n");
  out_.close();
  std::error_code error;
  if (out_) std::filesystem::rename(part_, path_, error);
  if (!out_ || error) {
    throw std::runtime_error(fmt::format("cannot write the page '{}': {}", path_.string(),
                                         error ? error.message() : std::strerror(errno)));
  }
  finished_ = true;
}

void PageFile::put(std::string_view text) {
  if (!out_.write(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw std::runtime_error(
        fmt::format("cannot write the page '{}': {}", path_.string(), std::strerror(errno)));
  }
}

}  // namespace flexura::view
