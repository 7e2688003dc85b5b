// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "import/cad/worker/slippage.hpp"
#include "import/cad/worker/worker_assembly.hpp"
#include "mesh/gmsh/worker/recognise.hpp"

namespace flexura::import::cad {
namespace {

constexpr double kToM = 1e-3;

std::array<double, 3> in_m(const gp_Pnt& p) {
  return {kToM * p.X(), kToM * p.Y(), kToM * p.Z()};
}

std::array<double, 3> as_array(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Points and outward normals of a face at places (u, v) of the unit square over its parameter rectangle.
class Sampled {
 public:
  explicit Sampled(const TopoDS_Face& face)
      : surface_(face), is_reversed_(face.Orientation() == TopAbs_REVERSED) {
    BRepTools::UVBounds(face, u0_, u1_, v0_, v1_);
  }

  void add(double u, double v) {
    gp_Pnt p;
    gp_Vec du, dv;
    surface_.D1(u0_ + (u1_ - u0_) * u, v0_ + (v1_ - v0_) * v, p, du, dv);
    gp_Vec normal = du.Crossed(dv);
    if (!(normal.Magnitude() > 1e-300)) return;
    normal.Normalize();
    if (is_reversed_) normal.Reverse();
    points_.emplace_back(kToM * p.X(), kToM * p.Y(), kToM * p.Z());
    normals_.emplace_back(normal.X(), normal.Y(), normal.Z());
  }
  Rows points() const { return rows_of(points_); }
  Rows normals() const { return rows_of(normals_); }

 private:
  static Rows rows_of(const std::vector<Eigen::Vector3d>& list) {
    Rows rows(static_cast<Eigen::Index>(list.size()), 3);
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      rows.row(i) = list[static_cast<std::size_t>(i)].transpose();
    return rows;
  }
  BRepAdaptor_Surface surface_;
  bool is_reversed_;
  double u0_ = 0, u1_ = 0, v0_ = 0, v1_ = 0;
  std::vector<Eigen::Vector3d> points_, normals_;
};

// A thread's flank may go round a hundred times: places that no number of turns makes one and the same (M. Roberts' sequence).
void recognise_slippage(const TopoDS_Face& face, FaceAnswer& answer) {
  constexpr int n = 240;
  constexpr double golden = 0.7548776662466927;  // 1 / x, x^3 = x + 1
  Sampled sampled(face);
  double whole = 0.0;
  for (int k = 1; k <= n; ++k)
    sampled.add(std::modf(k * golden, &whole), std::modf(k * golden * golden, &whole));
  const auto found = slippage_of(sampled.points(), sampled.normals());
  if (!found) return;
  answer.turned = true;
  answer.lead = found->lead;
  answer.axis = as_array(found->axis);
  answer.axis_point = as_array(found->point);
}

// What the face is, whatever the file calls it.
void recognise_face(const TopoDS_Face& face, FaceAnswer& answer) {
  constexpr int n = 7;
  Sampled sampled(face);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) sampled.add((i + 0.5) / n, (j + 0.5) / n);
  mesh::Face found;
  mesh::recognise(sampled.points(), sampled.normals(), found);
  answer.kind = static_cast<int>(found.kind);
  answer.radius = found.radius;
  answer.length = found.length;
  answer.hole = found.hole;
  answer.normal = as_array(found.normal);
  answer.axis_point = as_array(found.axis_point);
  answer.axis = as_array(found.axis);
  if (found.kind == mesh::FaceKind::other) recognise_slippage(face, answer);
}

void take_triangles(const TopoDS_Face& face, PartAnswer& part, FaceAnswer& answer, std::set<int>& seen_edges,
                    const TopTools_IndexedMapOfShape& edges) {
  TopLoc_Location at;
  const Handle(Poly_Triangulation) triangles = BRep_Tool::Triangulation(face, at);
  if (triangles.IsNull()) return;
  const auto first = static_cast<std::int32_t>(part.vertices.size() / 3);
  for (int i = 1; i <= triangles->NbNodes(); ++i)
    for (const double x : in_m(triangles->Node(i).Transformed(at.Transformation())))
      part.vertices.push_back(x);
  for (int i = 1; i <= triangles->NbTriangles(); ++i) {
    int a = 0, b = 0, c = 0;
    triangles->Triangle(i).Get(a, b, c);
    if (face.Orientation() == TopAbs_REVERSED) std::swap(b, c);
    for (const int corner : {a, b, c}) answer.triangles.push_back(first + corner - 1);
  }
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
    if (BRep_Tool::Degenerated(edge) || !seen_edges.insert(edges.FindIndex(edge)).second) continue;
    if (BRep_Tool::IsClosed(edge, face)) continue;  // a seam
    const Handle(Poly_PolygonOnTriangulation) line = BRep_Tool::PolygonOnTriangulation(edge, triangles, at);
    if (line.IsNull()) continue;
    for (int i = 2; i <= line->NbNodes(); ++i) {
      part.edges.push_back(first + line->Node(i - 1) - 1);
      part.edges.push_back(first + line->Node(i) - 1);
    }
  }
}

// How far a cylinder reaches along its axis: by its triangles, whose corners lie on its edges.  What was recognised is the middle of
// the parameters.
void measure_length(const PartAnswer& part, FaceAnswer& answer) {
  if (answer.kind != static_cast<int>(mesh::FaceKind::cylinder) || answer.triangles.empty()) return;
  const Eigen::Vector3d axis(answer.axis.data()), point(answer.axis_point.data());
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const std::int32_t v : answer.triangles) {
    const double z = axis.dot(Eigen::Vector3d(&part.vertices[3 * static_cast<std::size_t>(v)]) - point);
    low = std::min(low, z);
    high = std::max(high, z);
  }
  answer.length = high - low;
  answer.axis_point = as_array(point + 0.5 * (low + high) * axis);
}

}  // namespace

void describe_shape(const TopoDS_Shape& given, double deflection, PartAnswer& part) {
  TopoDS_Shape shape = given;
  GProp_GProps volume;
  // Adaptive Gauss integration to this relative error: far below what the faces' tolerance (1e-7 m) leaves.
  constexpr double kIntegration = 1e-9;
  BRepGProp::VolumeProperties(shape, volume, kIntegration, Standard_False, Standard_False);
  if (volume.Mass() < 0.0) {  // inside out
    shape.Reverse();
    volume = GProp_GProps();
    BRepGProp::VolumeProperties(shape, volume, kIntegration, Standard_False, Standard_False);
  }
  for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next()) ++part.solids;
  part.volume = volume.Mass() * std::pow(kToM, 3);
  part.center = in_m(volume.CentreOfMass());
  const gp_Mat I = volume.MatrixOfInertia();  // about the centre of mass
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      part.moments[static_cast<std::size_t>(3 * r + c)] = I.Value(r + 1, c + 1) * std::pow(kToM, 5);
  std::ostringstream text;
  BRepTools::Write(shape, text);
  part.brep = text.str();

  Bnd_Box box;
  BRepBndLib::Add(shape, box);
  const double size = box.IsVoid() ? 1.0 : std::sqrt(box.SquareExtent());
  BRepMesh_IncrementalMesh(shape, deflection * size, Standard_False, 0.2, Standard_False);
  TopTools_IndexedMapOfShape faces, edges;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  std::set<int> seen_edges;
  for (int i = 1; i <= faces.Extent(); ++i) {
    // The map keeps the first orientation it meets, that in the shell.
    const TopoDS_Face& face = TopoDS::Face(faces.FindKey(i));
    FaceAnswer answer;
    GProp_GProps area;
    BRepGProp::SurfaceProperties(face, area);
    answer.area = area.Mass() * kToM * kToM;
    answer.centroid = in_m(area.CentreOfMass());
    recognise_face(face, answer);
    take_triangles(face, part, answer, seen_edges, edges);
    measure_length(part, answer);
    part.faces.push_back(std::move(answer));
  }
}

}  // namespace flexura::import::cad
