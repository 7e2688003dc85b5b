// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/cad_file.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <vector>

namespace flexura::mesh {
namespace {

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// The first bytes of a file, fit to be shown in a message.
std::string shown(const std::string& text) {
  std::string out;
  for (const char c : text.substr(0, 24)) out += std::isprint(static_cast<unsigned char>(c)) ? c : '.';
  return "\"" + out + "\"";
}

/// The unit of length of a STEP file: the conversion-based one where there is one (INCH), else the SI unit.
std::string step_unit(const std::string& text) {
  std::string si;
  for (std::size_t at = text.find("LENGTH_UNIT"); at != std::string::npos;
       at = text.find("LENGTH_UNIT", at + 1)) {
    const std::size_t begin = text.rfind(';', at) + 1, end = text.find(';', at);
    if (end == std::string::npos) break;
    const std::string statement = upper(text.substr(begin, end - begin));
    if (const std::size_t quote = statement.find("CONVERSION_BASED_UNIT"); quote != std::string::npos) {
      const std::size_t first = statement.find('\'', quote), last = statement.find('\'', first + 1);
      if (last == std::string::npos) continue;
      const std::string name = statement.substr(first + 1, last - first - 1);
      if (name.find("INCH") != std::string::npos) return "inch";
      if (name.find("FOOT") != std::string::npos || name.find("FEET") != std::string::npos) return "ft";
      continue;
    }
    if (statement.find(".METRE.") == std::string::npos) continue;
    if (statement.find(".MILLI.") != std::string::npos)
      si = "mm";
    else if (statement.find(".CENTI.") != std::string::npos)
      si = "cm";
    else if (statement.find(".MICRO.") != std::string::npos)
      si = "um";
    else if (statement.find(".KILO.") != std::string::npos)
      si = "km";
    else
      si = "m";
  }
  return si;
}

/// Parameter 14 of an IGES file's global section (after two that set the delimiters), the unit flag.
std::string iges_unit(const std::string& text) {
  std::string global;
  for (std::size_t begin = 0; begin < text.size();) {
    std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) end = text.size();
    if (end - begin >= 73 && text[begin + 72] == 'G') global += text.substr(begin, 72);
    if (end - begin >= 73 && text[begin + 72] == 'D') break;
    begin = end + 1;
  }
  std::vector<std::string> fields(1);
  const auto special = [](const std::string& field, char otherwise) {  // "1H," names the delimiter
    return field.size() == 3 && field[1] == 'H' ? field[2] : otherwise;
  };
  char comma = ',', stop = ';';
  for (std::size_t k = 0; k < global.size(); ++k) {
    std::string& field = fields.back();
    const bool digits = !field.empty() && std::all_of(field.begin(), field.end(),
                                                      [](unsigned char c) { return std::isdigit(c); });
    if (global[k] == 'H' && digits && field.size() < 6) {  // a string of stated length follows
      const std::size_t length = std::stoul(field);
      field += global.substr(k, length + 1);
      k += length;
    } else if (global[k] == comma || global[k] == stop) {
      if (fields.size() == 1) comma = special(field, ',');
      if (fields.size() == 2) stop = special(field, ';');
      if (global[k] == stop && fields.size() > 2) break;
      fields.emplace_back();
    } else if (global[k] != ' ') {
      field += global[k];
    }
  }
  static const std::map<std::string, std::string> kFlags = {{"1", "inch"}, {"2", "mm"}, {"4", "ft"},
                                                            {"6", "m"},    {"7", "km"}, {"8", "mil"},
                                                            {"9", "um"},   {"10", "cm"}};
  if (fields.size() < 14) return "";
  const auto found = kFlags.find(fields[13]);
  return found == kFlags.end() ? "" : found->second;
}

/// A text that begins with "solid" can be binary: the length tells.
bool is_stl(const std::string& text) {
  std::uint32_t n = 0;
  if (text.size() >= 84) std::memcpy(&n, text.data() + 80, sizeof n);
  return (text.size() >= 84 && text.size() == 84 + 50 * static_cast<std::size_t>(n)) ||
         (text.starts_with("solid") && text.find("facet") != std::string::npos);
}

}  // namespace

double metres_in(const std::string& unit) {
  static const std::map<std::string, double> kUnits = {{"m", 1},       {"mm", 1e-3},   {"cm", 1e-2},
                                                       {"um", 1e-6},   {"km", 1e3},    {"inch", 0.0254},
                                                       {"in", 0.0254}, {"ft", 0.3048}, {"mil", 2.54e-5}};
  const auto found = kUnits.find(unit);
  if (found == kUnits.end())
    throw std::invalid_argument("\"" + unit +
                                "\" is no unit of length for a CAD file; take one of m, mm, cm, um, km, "
                                "inch, ft, mil");
  return found->second;
}

CadFile inspect_cad_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw std::invalid_argument(name + ": no such file");
  if (std::filesystem::is_directory(path, error))
    throw std::invalid_argument(name + ": is a folder; name the CAD file in it");
  if (!std::filesystem::is_regular_file(path, error))
    throw std::invalid_argument(name + ": is no file; name the CAD file itself");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::invalid_argument(name + ": cannot be opened for reading");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw std::invalid_argument(name + ": is empty");

  const std::string head = text.substr(0, 2000), extension = upper(path.extension().string());
  if (head.find("ISO-10303-21") != std::string::npos) {
    if (text.find("END-ISO-10303-21", text.size() > 4000 ? text.size() - 4000 : 0) == std::string::npos)
      throw std::invalid_argument(name +
                                  ": is a STEP file cut short (END-ISO-10303-21 is missing at its end)");
    return {"step", step_unit(text)};
  }
  if (head.find("CASCADE Topology") != std::string::npos ||
      head.find("DBRep_DrawableShape") != std::string::npos)
    return {"brep", ""};
  if (extension == ".STL") {
    if (!is_stl(text))
      throw std::invalid_argument(name +
                                  ": is neither a text STL (which begins with \"solid\") nor a binary one of "
                                  "the length that it states; "
                                  "save it again");
    return {"stl", ""};
  }
  const std::size_t line = head.find('\n');
  if (line != std::string::npos && line >= 73 && head[72] == 'S') return {"iges", iges_unit(text)};

  if (upper(head).find("<REFERENCE_FLEXDATA") != std::string::npos)
    throw std::invalid_argument(name +
                                ": is a FlexData file, finished modes and no geometry: name it as file of a "
                                "table [flexdata] instead of [geometry], "
                                "or give it to flexura reduce itself");
  const char* wanted =
      extension == ".IGS" || extension == ".IGES"   ? "not an IGES file: column 73 of its first line is no S"
      : extension == ".BREP" || extension == ".BRP" ? "not a BREP file: it does not name CASCADE Topology"
      : extension == ".STEP" || extension == ".STP" || extension == ".P21"
          ? "not a STEP file: it does not begin with ISO-10303-21"
          : "neither a STEP, an IGES, a BREP nor an STL file";
  throw std::invalid_argument(name + ": " + wanted + " (it begins with " + shown(text) + ")");
}

}  // namespace flexura::mesh
