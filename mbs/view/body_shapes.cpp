// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/body_shapes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "mbs/base/files/json_text.hpp"

namespace flexura::view {

namespace {

using nlohmann::json;

class Shape {
 public:
  Shape(const std::string& body, std::size_t number, const json& given) : given_(given) {
    place_ = fmt::format("body '{}', shape {}", body, number + 1);
    if (!given.is_object()) fail("is not a table");
    type_ = given.value("type", "");
    result_["type"] = type_;
  }

  json read() {
    if (type_ == "cylinder" || type_ == "cone") {
      positive("radius");
      positive("length");
      vector("position", {0.0, 0.0, 0.0});
      axis();
    } else if (type_ == "sphere") {
      positive("radius");
      vector("position", {0.0, 0.0, 0.0});
    } else if (type_ == "box") {
      vector("size", {});
      for (const auto& side : result_["size"]) {
        if (!(side.get<double>() > 0.0)) fail("has a 'size' that is not positive in all three directions");
      }
      vector("position", {0.0, 0.0, 0.0});
      rotation();
    } else if (type_ == "line") {
      points();
    } else {
      fail(fmt::format("has the type '{}'; types are box, cone, cylinder, line, sphere", type_));
    }
    color();
    return result_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw std::invalid_argument(place_ + " " + what); }

  void positive(const char* key) {
    if (!given_.contains(key) || !given_[key].is_number() || !(given_[key].get<double>() > 0.0)) {
      fail(fmt::format("({}) needs a positive number '{}'", type_, key));
    }
    result_[key] = given_[key].get<double>();
  }

  std::vector<double> numbers(const json& list, const char* key, std::size_t size) const {
    std::vector<double> values;
    if (list.is_array()) {
      for (const auto& value : list) {
        if (value.is_number() && std::isfinite(value.get<double>())) values.push_back(value.get<double>());
      }
    }
    if (values.size() != size || list.size() != size) {
      fail(fmt::format("({}) needs {} numbers in '{}'", type_, size, key));
    }
    return values;
  }

  void vector(const char* key, const std::vector<double>& otherwise) {
    result_[key] =
        !given_.contains(key) && !otherwise.empty() ? otherwise : numbers(given_.value(key, json()), key, 3);
  }

  void unit(const char* key, std::vector<double> values) {
    double square = 0.0;
    for (const double value : values) square += value * value;
    if (!(square > 0.0)) fail(fmt::format("({}) has an '{}' of length zero", type_, key));
    for (double& value : values) value /= std::sqrt(square);
    result_[key] = values;
  }

  void axis() {
    unit("axis", given_.contains("axis") ? numbers(given_["axis"], "axis", 3) : std::vector{0.0, 0.0, 1.0});
  }

  void rotation() {
    unit("rotation", given_.contains("rotation") ? numbers(given_["rotation"], "rotation", 4)
                                                 : std::vector{1.0, 0.0, 0.0, 0.0});
  }

  void color() {
    if (!given_.contains("color")) return;
    const std::string text =
        given_["color"].is_string() ? given_["color"].get<std::string>() : given_["color"].dump();
    if (text.size() != 7 || text[0] != '#' ||
        text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) {
      fail(fmt::format("({}) has the color '{}'; write it like '#88aacc'", type_, text));
    }
    result_["color"] = text;
  }

  void points() {
    const json list = given_.value("points", json::array());
    if (!list.is_array() || list.size() < 2) fail("(line) needs two or more 'points'");
    for (const auto& point : list) result_["points"].push_back(numbers(point, "points", 3));
  }

  const json& given_;
  json result_;
  std::string place_, type_;
};

}  // namespace

json parse_body_shapes(const std::string& body, const std::string& shape_json) {
  json shapes = json::array();
  if (shape_json.empty()) return shapes;
  const json given = files::try_read_json(shape_json);
  if (given.is_null()) return shapes;
  if (!given.is_array()) {
    throw std::invalid_argument(fmt::format(
        "body '{}' has shapes that are not a JSON list; simulate again to make the results anew", body));
  }
  for (std::size_t i = 0; i < given.size(); ++i) shapes.push_back(Shape(body, i, given[i]).read());
  return shapes;
}

}  // namespace flexura::view
