// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "cases/assembly/drawing.hpp"

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <Interface_Static.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Controller.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp_Explorer.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Ax1.hxx>
#include <gp_Ax2.hxx>
#include <gp_Trsf.hxx>
#include <stdexcept>

namespace drawing {
namespace {

TopoDS_Shape tidied(const TopoDS_Shape& shape) {
  ShapeUpgrade_UnifySameDomain unify(shape);
  unify.Build();
  TopExp_Explorer solid(unify.Shape(), TopAbs_SOLID);
  const TopoDS_Shape only = solid.Current();
  solid.Next();
  return solid.More() ? unify.Shape() : only;
}

TopLoc_Location location(const gp_Trsf& turn, const gp_Pnt& p) {
  gp_Trsf move;
  move.SetTranslation(gp_Vec(p.XYZ()));
  return TopLoc_Location(move * turn);
}

}  // namespace

TopoDS_Shape box(const gp_Pnt& low, const gp_Pnt& high) {
  return BRepPrimAPI_MakeBox(low, high).Solid();
}
TopoDS_Shape cylinder(const gp_Pnt& foot, const gp_Dir& axis, double radius, double length) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2(foot, axis), radius, length).Solid();
}
TopoDS_Shape sphere(const gp_Pnt& centre, double radius) {
  return BRepPrimAPI_MakeSphere(centre, radius).Solid();
}
TopoDS_Shape operator+(const TopoDS_Shape& a, const TopoDS_Shape& b) {
  return tidied(BRepAlgoAPI_Fuse(a, b).Shape());
}
TopoDS_Shape operator-(const TopoDS_Shape& a, const TopoDS_Shape& b) {
  return tidied(BRepAlgoAPI_Cut(a, b).Shape());
}

TopLoc_Location at(const gp_Pnt& p) {
  return location(gp_Trsf(), p);
}
TopLoc_Location turned(const gp_Pnt& p, const gp_Dir& axis, double angle) {
  gp_Trsf turn;
  turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), axis), angle);
  return location(turn, p);
}

Assembly::Assembly(const std::string& name) {
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document_);
  whole_ = group(name);
}

TDF_Label Assembly::group(const std::string& name) {
  const TDF_Label label = XCAFDoc_DocumentTool::ShapeTool(document_->Main())->NewShape();
  TDataStd_Name::Set(label, name.c_str());
  return label;
}

TDF_Label Assembly::part(const std::string& name, const TopoDS_Shape& shape, double density,
                         const std::string& color) {
  const TDF_Label label = XCAFDoc_DocumentTool::ShapeTool(document_->Main())->AddShape(shape, Standard_False);
  TDataStd_Name::Set(label, name.c_str());
  const auto text = [](const char* words) { return new TCollection_HAsciiString(words); };
  if (density > 0.0)
    XCAFDoc_DocumentTool::MaterialTool(document_->Main())
        ->SetMaterial(label, text("material"), text(""), 1e-3 * density, text("density measure"),
                      text("POSITIVE_RATIO_MEASURE"));
  Quantity_Color value;
  if (!color.empty() && Quantity_Color::ColorFromHex(color.c_str(), value))
    XCAFDoc_DocumentTool::ColorTool(document_->Main())->SetColor(label, value, XCAFDoc_ColorGen);
  return label;
}

void Assembly::place(const TDF_Label& what, const TopLoc_Location& location, const std::string& name) {
  place(whole_, what, location, name);
}

void Assembly::place(const TDF_Label& group, const TDF_Label& what, const TopLoc_Location& location,
                     const std::string& name) {
  const TDF_Label component =
      XCAFDoc_DocumentTool::ShapeTool(document_->Main())->AddComponent(group, what, location);
  if (!name.empty()) TDataStd_Name::Set(component, name.c_str());
}

void Assembly::write(const std::string& file, const std::string& unit, const std::string& schema) {
  XCAFDoc_DocumentTool::ShapeTool(document_->Main())->UpdateAssemblies();
  STEPControl_Controller::Init();  // makes the settings, which the writer reads when it is made
  Interface_Static::SetCVal("write.step.schema", schema.c_str());
  Interface_Static::SetCVal("write.step.unit", unit.c_str());
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document_, STEPControl_AsIs) || writer.Write(file.c_str()) != IFSelect_RetDone)
    throw std::runtime_error(file + ": cannot be written");
}

}  // namespace drawing
