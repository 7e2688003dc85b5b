// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/collada.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "import/urdf/xml.hpp"

namespace flexura::import::urdf {
namespace {

using Transform = Eigen::Affine3d;

constexpr int kDeepest = 64;
constexpr std::size_t kMostTriangles = 2000000, kMostVertices = 3 * kMostTriangles;
constexpr int kMostDrawn = 100000;  // nodes and geometries: a few can show one another without end

class Reader {
 public:
  Reader(const Element& root, SurfaceBuilder& builder) : builder_(builder) { collect(root, 0); }

  void read(const Element& root) {
    double metre = 1.0;
    if (const auto asset = root.child("asset"))
      if (const auto unit = asset->child("unit"))
        if (unit->has("meter")) metre = unit->number("meter");
    if (!(metre > 0.0)) builder_.refuse("its unit is not positive; save it again, or as STL");
    const Transform scale(Eigen::Scaling(metre));
    const auto scene = root.child("scene");
    const auto shown_scene = scene ? scene->child("instance_visual_scene") : std::nullopt;
    if (shown_scene) {
      draw_children(found(*shown_scene, "url"), scale, 0);
      return;
    }
    // Without a scene everything stands where it is.
    if (const auto library = root.child("library_geometries"))
      for (const Element& geometry : library->children("geometry")) draw_geometry(geometry, scale);
  }

 private:
  // Everything that has an id.
  void collect(const Element& element, int depth) {
    if (depth > kDeepest) element.refuse("elements stand within one another too deeply; save it as STL");
    if (element.has("id")) by_id_.emplace(element.text("id"), element);
    for (const Element& child : element.children()) collect(child, depth + 1);
  }

  const Element& found(const Element& from, const char* attribute) const {
    const std::string url = from.text(attribute);
    const auto at = url.starts_with("#") ? by_id_.find(url.substr(1)) : by_id_.end();
    if (at == by_id_.end())
      from.refuse(fmt::format("names \"{}\", which the file does not hold; save it again, or as STL", url));
    return at->second;
  }

  std::vector<double> numbers(const Element& element) const {
    const std::string text = element.text();
    std::vector<double> out;
    std::size_t at = 0;
    while (true) {
      at = text.find_first_not_of(" \t\r\n", at);
      if (at == std::string::npos) return out;
      const std::size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
      const auto value = parse_number(std::string_view(text).substr(at, end - at));
      if (!value) element.refuse("holds something that is no number; save it again, or as STL");
      out.push_back(*value);
      at = end;
    }
  }

  std::vector<double> numbers(const Element& element, std::size_t wanted) const {
    std::vector<double> out = numbers(element);
    if (out.size() != wanted)
      element.refuse(fmt::format("<{}> holds {} numbers, {} are wanted", element.tag(), out.size(), wanted));
    return out;
  }

  void draw_children(const Element& parent, const Transform& above, int depth) {
    if (depth > kDeepest)
      parent.refuse("nodes stand within one another too deeply, or within themselves; save it as STL");
    for (const Element& node : parent.children("node")) draw_node(node, above, depth + 1);
  }

  void draw_node(const Element& node, const Transform& above, int depth) {
    count(node);
    Transform X = above;
    for (const Element& step : node.children()) {
      const std::string tag = step.tag();
      if (tag == "matrix") {
        const std::vector<double> m = numbers(step, 16);
        X = X * Transform(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(m.data()));
      } else if (tag == "translate") {
        const std::vector<double> t = numbers(step, 3);
        X.translate(Vector3d::Map(t.data()));
      } else if (tag == "rotate") {
        const std::vector<double> r = numbers(step, 4);
        const Vector3d axis = Vector3d::Map(r.data());
        if (axis.norm() > 0.0)
          X.rotate(Eigen::AngleAxisd(r[3] * std::numbers::pi / 180.0, axis.normalized()));
      } else if (tag == "scale") {
        const std::vector<double> s = numbers(step, 3);
        X.scale(Vector3d::Map(s.data()));
      }
    }
    for (const Element& instance : node.children("instance_geometry"))
      draw_geometry(found(instance, "url"), X);
    for (const Element& instance : node.children("instance_controller"))
      instance.refuse("shows a geometry that is bent by a skeleton, which is not read; save it without");
    for (const Element& instance : node.children("instance_node")) {
      if (depth > kDeepest)
        node.refuse("nodes stand within one another too deeply, or within themselves; save it as STL");
      draw_node(found(instance, "url"), X, depth + 1);
    }
    draw_children(node, X, depth);
  }

  void count(const Element& element) {
    if (++n_drawn_ > kMostDrawn)
      element.refuse(
          fmt::format("is shown as number {} of what the scene holds; at most {} are taken: save it as STL",
                      n_drawn_, kMostDrawn));
  }

  void draw_geometry(const Element& geometry, const Transform& X) {
    count(geometry);
    const auto mesh = geometry.child("mesh");
    if (!mesh) return;  // splines and convex hulls are no pictures
    for (const Element& part : mesh->children()) {
      const std::string tag = part.tag();
      if (tag == "triangles" || tag == "polylist" || tag == "polygons" || tag == "tristrips" ||
          tag == "trifans")
        draw_polygons(part, tag, X);
    }
  }

  // The positions behind a polygon's VERTEX input: numbers of the surface.
  std::vector<int> vertices_of(const Element& vertices, const Transform& X) {
    for (const Element& input : vertices.children("input")) {
      if (input.text("semantic") != "POSITION") continue;
      const Element& source = found(input, "source");
      const auto array = source.child("float_array");
      if (!array) source.refuse("has no <float_array>; save it again, or as STL");
      const std::vector<double> x = numbers(*array);
      std::size_t stride = 3;
      if (const auto technique = source.child("technique_common"))
        if (const auto accessor = technique->child("accessor"); accessor && accessor->has("stride")) {
          const double given = accessor->number("stride");
          if (!(given >= 3.0) || given > 100.0)
            accessor->refuse("has a stride of fewer than three coordinates; save it again, or as STL");
          stride = static_cast<std::size_t>(given);
        }
      std::vector<int> out;
      for (std::size_t k = 0; k + 2 < x.size(); k += stride)
        out.push_back(builder_.vertex(X * Vector3d(x[k], x[k + 1], x[k + 2])));
      if (builder_.surface.vertices.size() > kMostVertices)
        builder_.refuse(fmt::format("holds more than {} vertices; save it coarser", kMostVertices));
      return out;
    }
    vertices.refuse("has no <input semantic=\"POSITION\">; save it again, or as STL");
  }

  void draw_polygons(const Element& part, const std::string& tag, const Transform& X) {
    std::size_t width = 0, offset = 0;
    std::vector<int> vertices;
    bool any = false;
    for (const Element& input : part.children("input")) {
      const double at = input.number("offset");
      if (!(at >= 0.0) || at > 100.0) input.refuse("has an offset that is none; save it again, or as STL");
      width = std::max(width, static_cast<std::size_t>(at) + 1);
      if (input.text("semantic") != "VERTEX") continue;
      offset = static_cast<std::size_t>(at);
      vertices = vertices_of(found(input, "source"), X);
      any = true;
    }
    if (!any) return;
    const bool mirrored = X.linear().determinant() < 0.0;
    const auto corner = [&](const Element& p, const std::vector<double>& index, std::size_t k) {
      const double at = index[k * width + offset];
      if (!(at >= 0.0) || !(at < static_cast<double>(vertices.size())) || at != std::floor(at))
        p.refuse(fmt::format("names vertex {} of {}", at, vertices.size()));
      return vertices[static_cast<std::size_t>(at)];
    };
    const auto triangle = [&](int a, int b, int c) {
      if (builder_.surface.triangles.size() >= kMostTriangles)
        builder_.refuse(fmt::format("holds more than {} triangles; save it coarser", kMostTriangles));
      mirrored ? builder_.triangle(a, c, b) : builder_.triangle(a, b, c);
    };
    std::vector<double> counts;
    if (const auto vcount = part.child("vcount")) counts = numbers(*vcount);
    for (const Element& p : part.children("p")) {
      const std::vector<double> index = numbers(p);
      const std::size_t n = index.size() / width;
      const auto fan = [&](std::size_t first, std::size_t count) {
        for (std::size_t k = 2; k < count; ++k)
          triangle(corner(p, index, first), corner(p, index, first + k - 1), corner(p, index, first + k));
      };
      if (tag == "triangles") {
        for (std::size_t k = 0; k + 2 < n; k += 3) fan(k, 3);
      } else if (tag == "polylist") {
        std::size_t first = 0;
        for (const double count : counts) {
          if (!(count >= 0.0) || !(static_cast<double>(first) + count <= static_cast<double>(n)))
            p.refuse("has fewer corners than <vcount> says; save it again, or as STL");
          fan(first, static_cast<std::size_t>(count));
          first += static_cast<std::size_t>(count);
        }
      } else if (tag == "tristrips") {
        for (std::size_t k = 2; k < n; ++k) {
          const int a = corner(p, index, k - 2), b = corner(p, index, k - 1), c = corner(p, index, k);
          k % 2 == 0 ? triangle(a, b, c) : triangle(b, a, c);
        }
      } else {  // polygons and fans
        fan(0, n);
      }
    }
  }

  SurfaceBuilder& builder_;
  std::map<std::string, Element> by_id_;
  int n_drawn_ = 0;
};

}  // namespace

void read_collada(const std::filesystem::path& file, const std::string& text, SurfaceBuilder& builder) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr)
    builder.refuse(fmt::format("is no COLLADA document: line {} is not XML; save it again, or as STL",
                               document.ErrorLineNum()));
  Findings none(file);
  const Element root(none, *document.RootElement());
  if (root.tag() != "COLLADA")
    builder.refuse(
        fmt::format("is no COLLADA document (it begins with <{}>); save it again, or as STL", root.tag()));
  Reader(root, builder).read(root);
}

}  // namespace flexura::import::urdf
