// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace flexura::files {

/// All texts and names in it become plain_text().
template <class Json = nlohmann::json>
void make_plain(Json& value);

/// The JSON of a file, its texts as plain_text().  Throws nlohmann::json::parse_error, also where lists and objects nest deeper than
/// 60: the library reads any depth, but copies and prints one level within the other and ends on the stack.
template <class Json = nlohmann::json>
Json read_json(std::string_view text);

/// The same, discarded (is_discarded()) where the text is none.
template <class Json = nlohmann::json>
Json try_read_json(std::string_view text);

}  // namespace flexura::files
