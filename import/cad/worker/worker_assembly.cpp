// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/worker/worker_assembly.hpp"

#include <Interface_InterfaceModel.hxx>
#include <Interface_Static.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepBasic_DerivedUnit.hxx>
#include <StepBasic_DerivedUnitElement.hxx>
#include <StepBasic_MeasureWithUnit.hxx>
#include <StepBasic_NamedUnit.hxx>
#include <StepBasic_SiUnit.hxx>
#include <StepBasic_SiUnitAndLengthUnit.hxx>
#include <StepBasic_SiUnitAndMassUnit.hxx>
#include <StepBasic_Unit.hxx>
#include <StepRepr_MeasureRepresentationItem.hxx>
#include <TCollection_AsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_Label.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDF_Tool.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>
#include <cmath>
#include <map>
#include <stdexcept>

namespace flexura::import::cad {
namespace {

constexpr double kToM = 1e-3;
constexpr int kDeepest = 200;           // assemblies in assemblies
constexpr std::size_t kMost = 100'000;  // instances

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
  const TCollection_ExtendedString& text = name->Get();
  std::string utf8(static_cast<std::size_t>(text.LengthOfCString()) + 1, '\0');
  Standard_PCharacter at = utf8.data();
  text.ToUTF8CString(at);
  utf8.resize(static_cast<std::size_t>(text.LengthOfCString()));
  return utf8;
}

double factor_of(const Handle(StepBasic_SiUnit) & unit) {
  if (!unit->HasPrefix()) return 1.0;
  constexpr double factors[] = {1e18, 1e15, 1e12, 1e9,  1e6,  1e3,   1e2,   1e1,
                                1e-1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18};
  return factors[static_cast<int>(unit->Prefix())];
}

// OpenCASCADE hands a density on as the number that stands in the file, whatever its unit (and writes wrong exponents itself), so
// the unit is read here: a mass over a length cubed, both with SI prefixes.
double density_unit(const Handle(Interface_InterfaceModel) & model, AssemblyAnswer& answer) {
  double found = 0.0;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const auto item = Handle(StepRepr_MeasureRepresentationItem)::DownCast(model->Value(i));
    if (item.IsNull() || item->Name().IsNull() || item->Name()->String().Search("ensity") < 0) continue;
    double mass_kg = 0.0, length_m = 0.0;
    if (const auto derived = item->Measure()->UnitComponent().DerivedUnit(); !derived.IsNull())
      for (int e = 1; e <= derived->NbElements(); ++e) {
        const Handle(StepBasic_NamedUnit) unit = derived->ElementsValue(e)->Unit();
        if (const auto mass = Handle(StepBasic_SiUnitAndMassUnit)::DownCast(unit); !mass.IsNull())
          mass_kg = 1e-3 * factor_of(mass);
        if (const auto length = Handle(StepBasic_SiUnitAndLengthUnit)::DownCast(unit); !length.IsNull())
          length_m = factor_of(length);
      }
    const double one = mass_kg > 0.0 && length_m > 0.0 ? mass_kg / std::pow(length_m, 3) : 0.0;
    if (one == 0.0 || (found > 0.0 && std::abs(one / found - 1.0) > 1e-9)) {
      answer.notes.push_back(
          "the file's densities have units that are not read (SI masses and lengths are, one and the same "
          "for all) and are left out");
      return 0.0;
    }
    found = one;
  }
  return found;
}

class Walker {
 public:
  /// `density_unit`: of the file's densities [kg/m^3], 0 where it is not known.
  Walker(const Handle(TDocStd_Document) & document, double density_unit, const AssemblyJob& job,
         AssemblyAnswer& answer)
      : density_unit_(density_unit),
        shapes_(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
        colors_(XCAFDoc_DocumentTool::ColorTool(document->Main())),
        job_(job),
        answer_(answer) {}

  void walk() {
    TDF_LabelSequence roots;
    shapes_->GetFreeShapes(roots);
    if (roots.IsEmpty())
      throw std::runtime_error("holds no shape; save it with its solids in the CAD program");
    if (roots.Length() > 1)
      answer_.notes.push_back("the file has " + std::to_string(roots.Length()) +
                              " roots; all of them are taken, side by side");
    for (int i = 1; i <= roots.Length(); ++i) visit(roots.Value(i), TopLoc_Location(), "", "", 0);
    if (answer_.instances.empty())
      throw std::runtime_error(
          "holds no solid, and a body needs a volume: close its surfaces to a solid in the CAD program and "
          "save it again");
  }

  std::vector<TopoDS_Shape> placed;  ///< of every instance, where overlaps are sought

 private:
  void visit(const TDF_Label& label, const TopLoc_Location& above, const std::string& path,
             const std::string& given, int depth) {
    if (depth > kDeepest) throw std::runtime_error("nests assemblies more than 200 deep; is it damaged?");
    TDF_Label what = label;
    TopLoc_Location at = above;
    if (XCAFDoc_ShapeTool::IsReference(label)) {
      at = above * XCAFDoc_ShapeTool::GetLocation(label);
      XCAFDoc_ShapeTool::GetReferredShape(label, what);
    }
    const std::string own = name_of(what);
    if (XCAFDoc_ShapeTool::IsAssembly(what)) {
      TDF_LabelSequence components;
      XCAFDoc_ShapeTool::GetComponents(what, components, Standard_False);
      const std::string here = path.empty() ? own : path + " / " + own;
      for (int i = 1; i <= components.Length(); ++i)
        visit(components.Value(i), at, here, name_of(components.Value(i)), depth + 1);
      return;
    }
    place(what, at, path, given, own, depth == 0);
  }

  void place(const TDF_Label& label, const TopLoc_Location& at, const std::string& path,
             const std::string& given, const std::string& own, bool is_root) {
    TCollection_AsciiString entry;
    TDF_Tool::Entry(label, entry);
    const std::string key = entry.ToCString();
    if (parts_.find(key) == parts_.end()) parts_[key] = make_parts(label, own, is_root);
    for (const auto& [part, name] : parts_[key]) {
      // CAD programs call a component by number or by its part.
      const bool speaks =
          !given.empty() && given != own && given.rfind("NAUO", 0) != 0 && given.rfind("=>", 0) != 0;
      add_instance(part, speaks && parts_[key].size() == 1 ? given : name, path, at);
    }
  }

  // A leaf is one part; a root that is no assembly has no structure to tell bodies by, so each of its solids is one.
  std::vector<std::pair<int, std::string>> make_parts(const TDF_Label& label, const std::string& own,
                                                      bool is_root) {
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    std::vector<TopoDS_Shape> solids;
    for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next()) solids.push_back(at.Current());
    if (solids.empty()) {
      answer_.notes.push_back("part \"" + own + "\" has no solid (open surfaces or curves) and is left out");
      return {};
    }
    std::vector<std::pair<int, std::string>> made;
    if (is_root && solids.size() > 1) {
      answer_.notes.push_back("\"" + own + "\" has no product structure: each of its " +
                              std::to_string(solids.size()) + " solids becomes a body");
      for (std::size_t i = 0; i < solids.size(); ++i) {
        const std::string name = (own.empty() ? "solid" : own) + "_" + std::to_string(i + 1);
        if (const int part = add_part(label, solids[i], name); part >= 0) made.emplace_back(part, name);
      }
    } else if (const int part = add_part(label, shape, own); part >= 0) {
      made.emplace_back(part, own);
    }
    return made;
  }

  int add_part(const TDF_Label& label, const TopoDS_Shape& shape, const std::string& name) {
    say(0.1 + 0.8 * static_cast<double>(answer_.parts.size()) /
                  (1.0 + static_cast<double>(answer_.parts.size())),
        "measuring the parts");
    PartAnswer part;
    part.name = name;
    describe_shape(shape, job_.deflection, part);
    if (!(part.volume > 0.0) || !std::isfinite(part.volume)) {
      answer_.notes.push_back("part \"" + name +
                              "\" encloses no volume (is its shell closed?) and is left out");
      return -1;
    }
    Quantity_Color color;
    if (colors_->GetColor(label, XCAFDoc_ColorSurf, color) ||
        colors_->GetColor(label, XCAFDoc_ColorGen, color) ||
        colors_->GetColor(shape, XCAFDoc_ColorSurf, color) ||
        colors_->GetColor(shape, XCAFDoc_ColorGen, color))
      part.color = Quantity_Color::ColorToHex(color).ToCString();
    // XCAF gives a thousandth of the number that the file has.
    part.density = density_unit_ * 1000.0 * XCAFDoc_MaterialTool::GetDensityForShape(label);
    if (!(part.density > 0.0) || !std::isfinite(part.density)) part.density = 0.0;
    answer_.parts.push_back(std::move(part));
    shapes_of_parts_.push_back(shape);  // one for each part that is kept
    return static_cast<int>(answer_.parts.size()) - 1;
  }

  void add_instance(int part, const std::string& name, const std::string& path, const TopLoc_Location& at) {
    if (answer_.instances.size() >= kMost) throw std::runtime_error("places more than 100000 bodies");
    const gp_Trsf T = at.Transformation();
    if (T.IsNegative() || std::abs(T.ScaleFactor() - 1.0) > 1e-9)
      throw std::runtime_error(
          "places \"" + name +
          "\" mirrored or scaled, which no motion does; save that part as one of its own");
    InstanceAnswer instance{.part = part, .name = name, .path = path};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        instance.R[static_cast<std::size_t>(3 * r + c)] = T.HVectorialPart().Value(r + 1, c + 1);
      instance.p[static_cast<std::size_t>(r)] = kToM * T.TranslationPart().Coord(r + 1);
    }
    answer_.instances.push_back(std::move(instance));
    if (job_.overlap > 0.0) placed.push_back(shapes_of_parts_[static_cast<std::size_t>(part)].Moved(at));
  }

  double density_unit_;
  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colors_;
  const AssemblyJob& job_;
  AssemblyAnswer& answer_;
  std::map<std::string, std::vector<std::pair<int, std::string>>> parts_;
  std::vector<TopoDS_Shape> shapes_of_parts_;
};

}  // namespace

void say(double fraction, const char* stage) {
  dprintf(4, "%.3f\t%s\n", fraction, stage);
}

void read_step(const AssemblyJob& job, AssemblyAnswer& answer) {
  try {
    say(0, "reading the STEP file");
    Handle(TDocStd_Document) document;
    XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
    STEPCAFControl_Reader reader;
    reader.SetNameMode(Standard_True);
    reader.SetColorMode(Standard_True);
    reader.SetMatMode(Standard_True);
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    if (reader.ReadFile(job.path.c_str()) != IFSelect_RetDone)
      throw std::runtime_error("is no STEP file that OpenCASCADE can read; save it again in the CAD program");
    say(0.05, "building the shapes");
    if (!reader.Transfer(document))
      throw std::runtime_error("holds no product with a shape; save it with its solids in the CAD program");
    const double unit = density_unit(reader.Reader().WS()->Model(), answer);
    Walker walker(document, unit, job, answer);
    walker.walk();
    if (job.overlap > 0.0) {
      answer.overlaps = find_overlaps(walker.placed, job.overlap);
      answer.parts.clear();
      answer.instances.clear();
    }
  } catch (const Standard_Failure& failure) {
    const char* const text = failure.GetMessageString();
    throw std::runtime_error(std::string("made OpenCASCADE fail") +
                             (text != nullptr && *text != '\0' ? std::string(" (") + text + ")" : "") +
                             "; save the file again in the CAD program");
  }
}

}  // namespace flexura::import::cad
