// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <TDF_Label.hxx>
#include <TDocStd_Document.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>
#include <string>

/// Assemblies drawn with OpenCASCADE and written as STEP with their product structure. Lengths in mm.
namespace drawing {

TopoDS_Shape box(const gp_Pnt& low, const gp_Pnt& high);
/// From `foot` along `axis`.
TopoDS_Shape cylinder(const gp_Pnt& foot, const gp_Dir& axis, double radius, double length);
TopoDS_Shape sphere(const gp_Pnt& centre, double radius);
TopoDS_Shape operator+(const TopoDS_Shape& a,
                       const TopoDS_Shape& b);  ///< joined, faces in one surface made one
TopoDS_Shape operator-(const TopoDS_Shape& a, const TopoDS_Shape& b);

TopLoc_Location at(const gp_Pnt& p);
/// Turned about the axis through the origin by `angle` [rad], then moved to p.
TopLoc_Location turned(const gp_Pnt& p, const gp_Dir& axis, double angle);

class Assembly {
 public:
  explicit Assembly(const std::string& name);
  /// A part that can be placed; density in kg/m^3, 0: none.
  TDF_Label part(const std::string& name, const TopoDS_Shape& shape, double density = 0.0,
                 const std::string& color = "");
  TDF_Label group(const std::string& name);
  /// Places a part or a group in a group, or in the whole.
  void place(const TDF_Label& what, const TopLoc_Location& location, const std::string& name = "");
  void place(const TDF_Label& group, const TDF_Label& what, const TopLoc_Location& location,
             const std::string& name = "");
  /// Throws std::runtime_error where it cannot be written.  `unit`: "MM", "INCH", "M"; `schema`: "AP203", "AP214IS", "AP242DIS".
  void write(const std::string& file, const std::string& unit = "MM", const std::string& schema = "AP214IS");

 private:
  Handle(TDocStd_Document) document_;
  TDF_Label whole_;
};

}  // namespace drawing
