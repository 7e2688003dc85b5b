// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/foreign_formats.hpp"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string_view>

namespace flexura::reduce {
namespace {

constexpr const char* kFromModel =
    "give the finite-element model itself (.inp, .bdf, .unv) in [geometry], or its matrices as Matrix Market "
    "or DMIG in "
    "[matrices], or modes with them in [mode_vectors]";
constexpr const char* kFromCad = "export the part as STEP";

struct Format {
  std::initializer_list<std::string_view> endings;
  const char *what, *way;
};

const Format kFormats[] = {
    {{".mnf"}, "a modal neutral file of Adams, whose binary format is not public", kFromModel},
    {{".h3d"},
     "an Altair H3D file, whose binary format is not public",
     "write the body as FlexData (.xml, with motion's FlexDataWriter), or give the finite-element model "
     "(.inp, .bdf)"},
    {{".op2", ".op4", ".pch"},
     "a results file of Nastran",
     "give the finite-element model (.bdf) or a table of its nodes, with the matrices (DMIG, OUTPUT4) in "
     "[matrices], or modes in "
     "[mode_vectors]"},
    {{".rst", ".rfl", ".full", ".mode", ".sub"}, "a binary file of Ansys", kFromModel},
    {{".cdb"},
     "a model of Ansys (CDWRITE)",
     "write it as Nastran bulk data or UNV, or its matrices as Matrix Market in [matrices]"},
    {{".odb", ".sim"},
     "a binary file of Abaqus",
     "give the .inp; matrices by *MATRIX GENERATE go into [matrices] as Matrix Market"},
    {{".fbi", ".sbr"}, "a flexible body of Simpack", kFromModel},
    {{".sid", ".sid_fem"}, "a SID file, which `flexura export` writes and nothing here reads", kFromModel},
    {{".frd"}, "a results file of CalculiX", "give its .inp"},
    {{".vtu", ".vtk", ".vtp"}, "a picture of ParaView", kFromModel},
    {{".k", ".key"}, "a model of LS-DYNA", "write it as Nastran bulk data or UNV"},
    {{".sldprt", ".sldasm"}, "a part of SolidWorks", kFromCad},
    {{".prt", ".asm"}, "a part of Creo or NX", kFromCad},
    {{".catpart", ".catproduct"}, "a part of CATIA", kFromCad},
    {{".ipt", ".iam"}, "a part of Inventor", kFromCad},
    {{".par", ".psm"}, "a part of Solid Edge", kFromCad},
    {{".fcstd", ".f3d", ".3dm", ".scad", ".dwg", ".dxf"}, "a drawing of a CAD program", kFromCad},
    {{".x_t", ".x_b", ".xmt_txt", ".sat", ".sab", ".jt"}, "a file of another geometry kernel", kFromCad},
    {{".obj", ".ply", ".off", ".3mf", ".dae", ".gltf", ".glb"},
     "a surface of triangles for pictures",
     "export the part as STEP, or its closed surface as STL"},
};

}  // namespace

std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool is_cad_ending(const std::string& ending) {
  constexpr std::string_view known[] = {".step", ".stp", ".p21", ".iges", ".igs", ".brep", ".brp", ".stl"};
  return std::ranges::find(known, ending) != std::end(known);
}

std::string foreign_format(const std::filesystem::path& file) {
  const std::string ending = ending_of(file);
  for (const Format& format : kFormats)
    if (std::ranges::find(format.endings, ending) != format.endings.end())
      return std::string("is ") + format.what + ": " + format.way;
  return "";
}

}  // namespace flexura::reduce
