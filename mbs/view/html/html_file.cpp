// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/html/html_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "mbs/view/html/html.hpp"
#include "mbs/view/html/resources.hpp"

namespace flexura::view {

namespace {

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

HtmlFile::HtmlFile(const std::filesystem::path& path, std::string_view title, std::string_view style)
    : path_((require_pages(), path)), file_(path), out_(file_.part(), std::ios::binary | std::ios::trunc) {
  if (!out_) fail(std::strerror(errno));
  put(head);
  put(escape_html(title));
  put("</title>\n<style>\n");
  put(style);
  put("</style>\n</head>\n<body>\n");
}

void HtmlFile::put(std::string_view html) {
  if (!out_.write(html.data(), static_cast<std::streamsize>(html.size()))) fail(std::strerror(errno));
}

void HtmlFile::finish(std::string_view script) {
  put("<script>\n");
  put(script);
  put("</script>\n</body>\n</html>\n");
  out_.close();
  if (!out_) fail(std::strerror(errno));
  file_.commit();
}

void HtmlFile::fail(std::string_view why) {
  throw std::runtime_error(fmt::format("cannot write the page '{}': {}", path_.string(), why));
}

}  // namespace flexura::view
