// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"

// glTF 2.0 in its binary form (Khronos Group, "glTF 2.0 Specification", sections 3.6 meshes with morph
// targets, 3.11 animations, 4 GLB).  One mesh; morph target j is the drawn displacement of mode j; animation
// j swings its weight through cos(2 pi t / T), as 32 straight pieces.
namespace flexura::superelement {
namespace {

using nlohmann::json;

constexpr int float_type = 5126, index_type = 5125;          // GL_FLOAT, GL_UNSIGNED_INT
constexpr int array_buffer = 34962, element_buffer = 34963;  // GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER
constexpr int triangles_mode = 4, lines_mode = 1;

/// The binary chunk, with the views and accessors that describe it.
class Buffer {
 public:
  template <typename Derived>
  int add(const Eigen::DenseBase<Derived>& values, int component_type, const char* type, Eigen::Index count,
          int target) {
    const auto size = static_cast<std::size_t>(values.size()) * sizeof(typename Derived::Scalar);
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}});
    if (target != 0) views_.back()["target"] = target;
    bytes_.append(reinterpret_cast<const char*>(values.derived().data()), size);
    bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
    accessors_.push_back({{"bufferView", views_.size() - 1},
                          {"componentType", component_type},
                          {"count", count},
                          {"type", type}});
    return static_cast<int>(accessors_.size()) - 1;
  }
  /// Points or displacements: 3 n floats.  The specification asks for the bounds.
  int add_vectors(const Eigen::VectorXf& values) {
    const Eigen::Map<const Eigen::Matrix3Xf> columns(values.data(), 3, values.size() / 3);
    const int accessor = add(values, float_type, "VEC3", columns.cols(), array_buffer);
    const Eigen::Vector3f low = columns.rowwise().minCoeff(), high = columns.rowwise().maxCoeff();
    accessors_[static_cast<std::size_t>(accessor)]["min"] = {low.x(), low.y(), low.z()};
    accessors_[static_cast<std::size_t>(accessor)]["max"] = {high.x(), high.y(), high.z()};
    return accessor;
  }
  json& accessor(int number) { return accessors_[static_cast<std::size_t>(number)]; }
  const json& views() const { return views_; }
  const json& accessors() const { return accessors_; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  json views_ = json::array(), accessors_ = json::array();
};

using Indices = Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 1>;

/// The triangles of the free surface (false) or of all interfaces (true).
Indices corners(const Surface& surface, bool on_interface) {
  std::vector<std::uint32_t> list;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const bool is =
        !surface.triangle_interface.empty() && surface.triangle_interface[static_cast<std::size_t>(t)] >= 0;
    if (is != on_interface) continue;
    for (int c = 0; c < 3; ++c) list.push_back(static_cast<std::uint32_t>(surface.triangles(t, c)));
  }
  return Eigen::Map<const Indices>(list.data(), static_cast<Eigen::Index>(list.size()));
}

json material(const char* name, double r, double g, double b) {
  return {{"name", name},
          {"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {r, g, b, 1.0}}, {"metallicFactor", 0.1}, {"roughnessFactor", 0.6}}}};
}

void append_u32(std::string& out, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  char bytes[4];
  std::memcpy(bytes, &word, 4);
  out.append(bytes, 4);
}

}  // namespace

void write_gltf(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes) {
  exchange::require_surface(se);
  const Surface& surface = se.surface;
  Buffer buffer;
  const Eigen::VectorXf positions =
      Eigen::Map<const Eigen::VectorXd>(surface.vertices.data(), surface.vertices.size()).cast<float>();
  const json attributes = {{"POSITION", buffer.add_vectors(positions)}};
  json targets = json::array(), names = json::array(), animations = json::array();
  const auto first = static_cast<std::size_t>(modes.n_rigid);
  const std::size_t n_modes = modes.modes.size() - first;
  for (std::size_t j = first; j < modes.modes.size(); ++j) {
    targets.push_back({{"POSITION", buffer.add_vectors(exchange::drawn_shape(se, modes.modes[j]))}});
    names.push_back(exchange::mode_name(modes, j));
  }

  constexpr int pieces = 32;
  constexpr double period = 1.5;  // of the swing on the screen [s]
  const Eigen::VectorXf times = Eigen::VectorXf::LinSpaced(pieces + 1, 0.0f, static_cast<float>(period));
  const int time = buffer.add(times, float_type, "SCALAR", times.size(), 0);
  buffer.accessor(time)["min"] = {times.minCoeff()};
  buffer.accessor(time)["max"] = {times.maxCoeff()};
  for (std::size_t j = 0; j < n_modes; ++j) {
    Eigen::VectorXf weights = Eigen::VectorXf::Zero((pieces + 1) * static_cast<Eigen::Index>(n_modes));
    for (int i = 0; i <= pieces; ++i) {
      weights[i * static_cast<Eigen::Index>(n_modes) + static_cast<Eigen::Index>(j)] =
          static_cast<float>(std::cos(2.0 * std::numbers::pi * i / pieces));
    }
    const int output = buffer.add(weights, float_type, "SCALAR", weights.size(), 0);
    animations.push_back({{"name", names[j]},
                          {"samplers", {{{"input", time}, {"output", output}, {"interpolation", "LINEAR"}}}},
                          {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}});
  }

  json primitives = json::array();
  const auto add_primitive = [&](const Indices& indices, int mode, int which) {
    if (indices.size() == 0) return;
    primitives.push_back(
        {{"attributes", attributes},
         {"indices", buffer.add(indices, index_type, "SCALAR", indices.size(), element_buffer)},
         {"mode", mode},
         {"material", which},
         {"targets", targets}});
  };
  add_primitive(corners(surface, false), triangles_mode, 0);
  add_primitive(corners(surface, true), triangles_mode, 1);
  const Indices edges = Eigen::Map<const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>>(surface.edges.data(),
                                                                                         surface.edges.size())
                            .cast<std::uint32_t>();
  add_primitive(edges, lines_mode, 2);

  // The first mode stands deflected where a viewer plays nothing.
  std::vector<double> at_rest(n_modes, 0.0);
  at_rest[0] = 1.0;
  const json header = {
      {"asset", {{"version", "2.0"}, {"generator", "flexura"}}},
      {"scene", 0},
      {"scenes", {{{"name", se.name}, {"nodes", {0}}}}},
      // glTF's y is up, ours is z.
      {"nodes",
       {{{"name", se.name}, {"mesh", 0}, {"rotation", {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}}}}},
      {"meshes",
       {{{"name", se.name},
         {"primitives", primitives},
         {"weights", at_rest},
         {"extras", {{"targetNames", names}}}}}},
      {"materials",
       {material("part", 0.55, 0.62, 0.70), material("interface", 0.86, 0.45, 0.12),
        material("edge", 0.05, 0.07, 0.1)}},
      {"animations", animations},
      {"buffers", {{{"byteLength", buffer.bytes().size()}}}},
      {"bufferViews", buffer.views()},
      {"accessors", buffer.accessors()}};
  std::string text = header.dump(-1, ' ', false, json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');

  constexpr std::size_t heads = 12 + 8 + 8;
  if (heads + text.size() + buffer.bytes().size() > 0xFFFFFFFFu) {
    throw std::invalid_argument(
        fmt::format("{} modes of {} vertices are more than the 4 GB a .glb file can hold; "
                    "write fewer with --count",
                    n_modes, surface.vertices.rows()));
  }
  std::string out = "glTF";
  append_u32(out, 2);
  append_u32(out, heads + text.size() + buffer.bytes().size());
  append_u32(out, text.size());
  out += "JSON" + text;
  append_u32(out, buffer.bytes().size());
  out.append("BIN\0", 4);
  out += buffer.bytes();
  write_whole(path, out);
}

}  // namespace flexura::superelement
