// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <BRepAlgoAPI_Common.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <cmath>

#include "import/cad/worker/worker_assembly.hpp"

namespace flexura::import::cad {
namespace {

constexpr double kToM = 1e-3;

bool overlap(const TopoDS_Shape& a, const TopoDS_Shape& b, double more_than, OverlapAnswer& found) {
  BRepAlgoAPI_Common common(a, b);
  if (!common.IsDone() || common.HasErrors()) return false;
  GProp_GProps volume, area;
  BRepGProp::VolumeProperties(common.Shape(), volume);
  BRepGProp::SurfaceProperties(common.Shape(), area);
  found.volume = std::abs(volume.Mass()) * std::pow(kToM, 3);
  const double surface = area.Mass() * kToM * kToM;
  if (!(found.volume > 0.0) || !(surface > 0.0)) return false;
  found.thickness = 2.0 * found.volume / surface;
  const gp_Pnt c = volume.CentreOfMass();
  found.place = {kToM * c.X(), kToM * c.Y(), kToM * c.Z()};
  return found.thickness > more_than;
}

}  // namespace

std::vector<OverlapAnswer> find_overlaps(const std::vector<TopoDS_Shape>& shapes, double more_than) {
  std::vector<Bnd_Box> boxes(shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    BRepBndLib::Add(shapes[i], boxes[i]);
    boxes[i].SetGap(0.0);
  }
  std::vector<OverlapAnswer> found;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    say(0.9 + 0.1 * static_cast<double>(i) / static_cast<double>(shapes.size()),
        "looking for parts that overlap");
    for (std::size_t j = i + 1; j < shapes.size(); ++j) {
      if (boxes[i].IsOut(boxes[j])) continue;
      OverlapAnswer one;
      one.a = static_cast<int>(i);
      one.b = static_cast<int>(j);
      try {
        if (overlap(shapes[i], shapes[j], more_than, one)) found.push_back(one);
      } catch (const Standard_Failure&) {  // that pair is not judged
      }
    }
  }
  return found;
}

}  // namespace flexura::import::cad
