// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/html/page_file.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "mbs/view/html/html.hpp"
#include "mbs/view/html/resources.hpp"

namespace flexura::view {

PageFile::PageFile(const std::filesystem::path& path, std::string_view title)
    : file_(path, title, page_style()) {
  file_.put("<div id=\"app\"><p class=\"loading\">Loading " + escape_html(title) +
            " ...</p></div>\n<noscript>This page draws with JavaScript and WebGL; allow scripts for "
            "it.</noscript>\n");
}

void PageFile::add_block(std::string_view name, std::string_view type, std::string_view base64) {
  file_.put(fmt::format("<script type=\"text/plain\" data-block=\"{}\" data-type=\"{}\">", escape_html(name),
                        type));
  file_.put(base64);
  file_.put("</script>\n");
}

void PageFile::finish(const nlohmann::json& header) {
  file_.put("<script type=\"application/json\" id=\"header\">");
  // Names may hold anything a file system allows: bytes that are not UTF-8 become replacement characters.
  file_.put(escape_script(header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
  file_.put("</script>\n");
  file_.finish(page_script());
}

}  // namespace flexura::view
