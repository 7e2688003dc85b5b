// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mesh/import/nastran.hpp"
#include "mesh/model/cells/cell.hpp"
#include "mesh/model/geometry.hpp"
#include "tests/mesh/scratch.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string data(const std::string& name) {
  return FLEXURA_SOURCE_DIR "/tests/mesh/data/" + name;
}

ImportedModel read_text(const std::string& text) {
  return read_nastran(Scratch("deck.bdf", text).path());
}

std::string refusal(const std::string& text) {
  try {
    read_text(text);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "(accepted)";
}

std::int64_t label_of(const ImportedModel& model, Index node) {
  return model.mesh.node_label.at(static_cast<std::size_t>(node));
}

/// FEDEM's cantilevers, large field: 1 x 0.2 x 0.1 m of steel with a spider (RBE2) at each end.  Coordinates
/// carry ten digits: 1e-9 of the volume.
TEST(NastranDeck, FedemCantileversOfSolids) {
  struct Row {
    const char* name;
    CellType type;
    Index cells;
    std::int64_t first, second;  // reference nodes of the ties, as the ASET card names them
  };
  for (const Row& row :
       {Row{"CHEXA08_.nas", CellType::hex8, 64, 8, 128}, Row{"CTETRA04_.nas", CellType::tet4, 586, 1, 49},
        Row{"CPENTA06_.nas", CellType::wedge6, 96, -1, -1}}) {
    const ImportedModel model = read_nastran(data(row.name));
    ASSERT_EQ(model.mesh.solids.size(), 1u) << row.name;
    EXPECT_EQ(model.mesh.solids[0].type, row.type);
    EXPECT_EQ(model.mesh.n_solid_cells(), row.cells);
    const Volumes v = measure_volume(model.mesh);
    EXPECT_NEAR(v.volume, 0.02, 1e-9) << row.name;
    EXPECT_EQ(find_pieces(model.mesh).count, 1) << row.name;
    ASSERT_EQ(model.materials.size(), 1u);
    EXPECT_EQ(model.materials[0].E, 2.067999949e11);
    EXPECT_EQ(model.materials[0].nu, 0.289999992);
    EXPECT_EQ(model.materials[0].rho, 7820);
    EXPECT_EQ(model.mesh.solids[0].material.at(0), 0);
    ASSERT_EQ(model.ties.size(), 2u);
    ASSERT_EQ(model.kept.size(), 2u);
    for (const ImportedTie& tie : model.ties) {
      EXPECT_EQ(tie.kind, ImportedTie::Kind::rigid);
      EXPECT_EQ(tie.dofs, (std::array<bool, 6>{true, true, true, true, true, true}));
      const double z = model.mesh.points(tie.reference, 2);
      for (const Index node : tie.nodes) EXPECT_NEAR(model.mesh.points(node, 2), z, 1e-9);
      EXPECT_TRUE(label_of(model, tie.reference) == label_of(model, model.kept[0].node) ||
                  label_of(model, tie.reference) == label_of(model, model.kept[1].node));
    }
    if (row.first > 0) {
      EXPECT_EQ(label_of(model, model.kept[0].node), row.first);
      EXPECT_EQ(label_of(model, model.kept[1].node), row.second);
    }
  }
}

TEST(NastranDeck, FedemCantileverOfBars) {
  const ImportedModel model = read_nastran(data("CBAR02_.nas"));
  ASSERT_EQ(model.bars.size(), 8u);
  EXPECT_EQ(model.mesh.n_nodes(), 9);
  double length = 0;
  for (const ImportedBar& bar : model.bars) {
    length += (model.mesh.points.row(bar.nodes[1]) - model.mesh.points.row(bar.nodes[0])).norm();
    EXPECT_EQ(bar.orientation, Vector3d::UnitY());
    EXPECT_EQ(bar.A, 0.020000001);
    EXPECT_EQ(bar.I_zz, 1.666666503e-5);  // plane 1: in y, the bar's thin side, 0.2 x 0.1^3 / 12
    EXPECT_EQ(bar.I_yy, 6.666666741e-5);
    EXPECT_EQ(bar.J, 4.577562868e-5);
    EXPECT_EQ(bar.kappa_y, 0.833333313);
  }
  EXPECT_NEAR(length, 1, 1e-9);
}

/// Nodes at the places of the reference cell, written in Nastran's order: a wrong permutation bends edges, so
/// the least over greatest det J is no longer 1.
TEST(NastranDeck, QuadraticCellsArePermuted) {
  const std::vector<int> hexahedron = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15},
                         wedge = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11},
                         tetrahedron = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
                         pyramid = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  for (const auto& [name, type, order] :
       {std::tuple{"CHEXA", CellType::hex20, hexahedron}, std::tuple{"CPENTA", CellType::wedge15, wedge},
        std::tuple{"CTETRA", CellType::tet10, tetrahedron},
        std::tuple{"CPYRAM", CellType::pyramid13, pyramid}}) {
    std::string text, element = fmt::format("{},7,1", name);
    const auto& x = reference_nodes(type);
    for (std::size_t k = 0; k < order.size(); ++k) {
      text += fmt::format("GRID,{},,{:.3f},{:.3f},{:.3f}\n", k + 1, x(order[k], 0), x(order[k], 1),
                          x(order[k], 2));
      if ((k + 2) % 8 == 0) element += "\n";
      element += fmt::format(",{}", k + 1);
    }
    const ImportedModel model = read_text(text + element + "\n");
    ASSERT_EQ(model.mesh.solids.at(0).type, type);
    EXPECT_NEAR(measure_quality(model.mesh).min_ratio, 1, 1e-12) << name;
    EXPECT_NEAR(measure_volume(model.mesh).volume, volume_quadrature(type).weights.sum(), 1e-12) << name;
  }
}

/// One grid in each kind of system, in free, small and large field and with Nastran's short exponents.
TEST(NastranDeck, CoordinateSystemsAndFields) {
  const ImportedModel model = read_text(
      "SOL 103\nCEND\nBEGIN BULK\n"
      "CORD2C,5,,10.,0.,0.,10.,0.,1.,\n,11.,0.,0.\n"
      "CORD2S,6,5,1.,90.,0.,1.,90.,1.,\n,2.,90.,0.\n"  // origin (10,1,0), z up, x along the cylinder's radius
                                                       // (0,1,0)
      "GRID           1       5     2.0     90.     1.0\n"
      "GRID*                  2               6          2.+0           90.D00\n*             9.0+1          "
      "     0\n"
      "GRID,3,,1.5-1,0.,0.\nGRID,4,,0.,0.,1.\nGRID,5,,0.,1.,0.\nGRID,6,,0.,0.,0.\n"
      "CTETRA,1,1,6,3,5,4\n"
      "CONM2,9,1,5,2.5,1.,90.,0.\n,3.,.1,4.,.2,.3,5.\n"
      "CONM2,10,2,0,1.\n"
      "RBE3,11,,1,123456,2.0,123,3,4,\n,1.,123,5\n"
      "SPC1,1,123,3,THRU,5\nPLOAD4,1,1,2.\nENDDATA\nGARBAGE\n");
  const auto place = [&](std::int64_t label) -> Vector3d {
    for (Index k = 0; k < model.mesh.n_nodes(); ++k)
      if (label_of(model, k) == label) return model.mesh.points.row(k).transpose();
    return Vector3d::Constant(NAN);
  };
  EXPECT_LT((place(1) - Vector3d(10, 2, 1)).norm(), 1e-14);
  // Spherical (2, 90, 90) in axes x = (0,1,0), z = (0,0,1), y = z cross x = (-1,0,0): 2 along y from
  // (10,1,0).
  EXPECT_LT((place(2) - Vector3d(8, 1, 0)).norm(), 1e-14);
  EXPECT_LT((place(3) - Vector3d(0.15, 0, 0)).norm(), 1e-16);
  ASSERT_EQ(model.masses.size(), 2u);
  EXPECT_EQ(model.masses[0].mass, 2.5);
  EXPECT_LT((model.masses[0].offset - Vector3d(0, 1, 0)).norm(), 1e-14);
  EXPECT_NEAR(model.masses[0].inertia(0, 1), -0.1, 1e-15);
  EXPECT_NEAR(model.masses[0].inertia(2, 2), 5, 1e-15);
  ASSERT_EQ(model.ties.size(), 1u);
  EXPECT_EQ(model.ties[0].weights, (std::vector<double>{2, 2, 1}));
  EXPECT_EQ(model.fixed.size(), 3u);
  EXPECT_THAT(model.messages, ::testing::Contains(HasSubstr("1 card PLOAD4 is not used (first in")));
}

/// The same bar in mm, t, s: E in MPa, density in t/mm^3.  Stiffness E A / l and mass rho A l must come out
/// alike.
TEST(NastranDeck, ConsistentUnitsScaleToSi) {
  const auto deck = [](double mm, double E, double rho) {
    return fmt::format(
        "GRID,1,,0.,0.,0.\nGRID,2,,{:.6f},0.,0.\nMAT1,1,{:.6e},,.3,{:.6e}\nPBAR,1,1,{:.9e},{:.9e},{:.9e},{:."
        "9e}\n"
        "CBAR,1,1,1,2,0.,1.,0.\nCONM2,2,2,0,{:.6e},0.,{:.6f},0.,\n,{:.6e},,"
        "{:.6e}\n",
        0.5 * mm, E, rho, 2e-4 * mm * mm, 3e-9 * std::pow(mm, 4), 4e-9 * std::pow(mm, 4),
        5e-9 * std::pow(mm, 4), rho * 1e-3 * std::pow(mm, 3), 0.1 * mm, rho * 1e-6 * std::pow(mm, 5),
        rho * 1e-6 * std::pow(mm, 5));
  };
  ImportedModel model = read_text(deck(1000, 2.1e5, 7.85e-9));
  scale_to_si(model, 1e-3, 1e3, 1);
  const ImportedModel si = read_text(deck(1, 2.1e11, 7850));
  EXPECT_LT((model.mesh.points - si.mesh.points).norm(), 1e-12);
  EXPECT_NEAR(model.materials.at(0).E / si.materials.at(0).E, 1, 1e-12);
  EXPECT_NEAR(model.materials.at(0).rho / si.materials.at(0).rho, 1, 1e-12);
  EXPECT_NEAR(model.bars.at(0).A / si.bars.at(0).A, 1, 1e-9);
  EXPECT_NEAR(model.bars.at(0).I_yy / si.bars.at(0).I_yy, 1, 1e-9);
  EXPECT_NEAR(model.bars.at(0).J / si.bars.at(0).J, 1, 1e-9);
  EXPECT_NEAR(model.masses.at(0).mass / si.masses.at(0).mass, 1, 1e-6);
  EXPECT_NEAR(model.masses.at(0).inertia(0, 0) / si.masses.at(0).inertia(0, 0), 1, 1e-6);
  EXPECT_LT((model.masses.at(0).offset - si.masses.at(0).offset).norm(), 1e-12);
  EXPECT_THROW(scale_to_si(model, 0, 1, 1), std::invalid_argument);
}

// What no structure has is refused where it stands: a negative stiffness would make a mechanism explode, not stop here.
TEST(NastranDeck, NumbersThatNoStructureHasAreRefusedWithTheirLine) {
  const std::string grids =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nMAT1,7,2.+11,,.3,7850.\n";
  const auto shell = [&](const std::string& t) {
    return refusal(grids + "PSHELL,1,7," + t + ",7\nCTRIA3,1,1,1,2,3\n");
  };
  for (const char* const t : {"-1.-3", "0.", ""})
    EXPECT_THAT(shell(t), AllOf(HasSubstr("deck.bdf, line 7: shell element 1 has the thickness"),
                                HasSubstr("above 0")));
  const auto mass = [&](const std::string& numbers) {
    return refusal(grids + "PBAR,1,7,1.-3,1.-7,1.-7,1.-7\nCBAR,1,1,1,2,0.,1.,0.\nCONM2,9,2,0," + numbers +
                   "\n");
  };
  EXPECT_THAT(mass("-2."), HasSubstr("deck.bdf, line 8: CONM2 9 has the mass -2; it must be above 0"));
  EXPECT_THAT(mass("0."), HasSubstr("CONM2 9 has the mass 0"));
  EXPECT_THAT(mass("2.,,,,\n,.01,,.01,,,1."),
              HasSubstr("line 8: CONM2 9 has the principal moments of inertia 0.01, 0.01, 1;"));
  EXPECT_EQ(mass("0.,,,,\n,.01,,.01,,,.02"), "(accepted)");  // a moment of inertia alone
  const auto bar = [&](const std::string& numbers) {
    return refusal(grids + "PBAR,1,7," + numbers + "\nCBAR,1,1,1,2,0.,1.,0.\n");
  };
  EXPECT_THAT(bar("-1.-4,1.-8,1.-8,1.-8"),
              HasSubstr("deck.bdf, line 7: CBAR 1 has the area -0.0001; it must be above 0"));
  EXPECT_THAT(bar("1.-4,-1.-8,1.-8,1.-8"),
              HasSubstr("second moment of area I_zz -1e-08; it must be at least 0"));
  EXPECT_THAT(bar("1.-4,1.-8,-1.-8,1.-8"), HasSubstr("second moment of area I_yy -1e-08"));
  EXPECT_THAT(bar("1.-4,1.-8,1.-8,-1.-8"), HasSubstr("torsion constant -1e-08"));
  EXPECT_THAT(bar("1.-4,1.-8,1.-8,1.-8\n+,,,,,,,,\n+,,,2.-8"), HasSubstr("product of area I_yz = 2e-08"));
  EXPECT_THAT(refusal(grids + "CONROD,1,1,2,7,0.\n"), HasSubstr("line 6: CONROD 1 has the area 0"));
  EXPECT_THAT(refusal(grids + "CTETRA,1,1,1,2,3,4\nCELAS2,2,-5.,1,1,2,1\n"),
              HasSubstr("line 7: CELAS2 2 has the stiffness -5; it must be at least 0"));
  EXPECT_THAT(refusal(grids + "CTETRA,1,1,1,2,3,4\nPBUSH,3,K,1.,-2.,1.\nCBUSH,2,3,1,2,0.,1.,0.\n"),
              HasSubstr("line 8: CBUSH 2 has the stiffness -2"));
}

// Free fields beyond the eighth go on with the card, as some programs write it; left out, they would be zeros.  One word
// there is the mark of the continuation, "+1" too.
TEST(NastranDeck, MoreFieldsThanALineHoldsGoOnWithTheCard) {
  const auto shear = [](const std::string& section) {
    const ImportedModel model = read_text(
        "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nMAT1,1,2.+11,,.3,7850.\nCBAR,1,1,1,2,0.,1.,0.\n" + section);
    return std::array{model.bars.at(0).kappa_y, model.bars.at(0).kappa_z};
  };
  for (const char* rest :
       {",,,,,,,,,,,.5,.25\n", "\n,\n,.5,.25\n", ",,,+1\n+1\n,.5,.25\n", ",,,P1\n+P1,,,,,,,,,.5,.25\n"})
    EXPECT_EQ(shear("PBAR,1,1,.01,1.-5,2.-5,3.-5" + std::string(rest)), (std::array{0.5, 0.25})) << rest;
}

// Sorted decks: continuations that do not stand behind their cards are found by their marks.
TEST(NastranDeck, ContinuationsGoToTheCardThatWaitsForThem) {
  const ImportedModel model = read_text(
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nMAT1,1,2.+11,,.3,7850.\n"
      "CBAR           1       1       1       2      0.      1.      0.        +C1\n"
      "CBAR           2       1       1       2      0.      1.      0.        +C2\n"
      "+C1                           .1\n"
      "+C2                           .2\n"
      "PBAR           1       1     .01   1.-5    2.-5    3.-5\n");
  EXPECT_EQ(model.bars.at(0).offset[0].x(), 0.1);
  EXPECT_EQ(model.bars.at(1).offset[0].x(), 0.2);
}

// Words behind the fields, with commas; two bulk data sections.
TEST(NastranDeck, CommasBehindFixedFieldsAndSecondSections) {
  const std::string bars =
      "GRID           1              0.      0.      0.                        a, b\nGRID,2,,1.,0.,0.\n"
      "CBAR           1       1       1       2      0.      1.      0.\nMAT1,1,2.+11,,.3,7850.\n"
      "PBAR,1,1,.01,1.-5,2.-5,3.-5\n";
  EXPECT_EQ(read_text(bars).bars.size(), 1u);
  EXPECT_THAT(refusal("SOL 101\nCEND\nBEGIN BULK\n" + bars + "BEGIN SUPER=2\nGRID,1\n"),
              HasSubstr("line 9: a second section of bulk data (BEGIN SUPER=2); the first begins in line 3"));
  EXPECT_EQ(read_text("SOL 101\nCEND\nBEGIN BULK\n" + bars + "ENDDATA\nBEGIN BULK\n").bars.size(), 1u);
}

// A name in quotes over several lines, with the separators of another system.
TEST(NastranDeck, IncludesOverSeveralLines) {
  const Scratch scratch(
      "deck.bdf",
      "SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\n"
      "include 'mesh\\\n   bars.\n   dat'\nMAT1,1,2.+11,,.3,7850.\nPBAR,1,1,.01,1.-5,2.-5,3.-5\n");
  std::filesystem::create_directories(scratch.path().parent_path() / "mesh");
  std::ofstream(scratch.path().parent_path() / "mesh/bars.dat") << "CBAR,1,1,1,2,0.,1.,0.\n";
  EXPECT_EQ(read_nastran(scratch.path()).bars.size(), 1u);
}

// Loss factors of plies are those of their materials; another one for the whole laminate is told.
TEST(NastranDeck, PliesHaveTheLossFactorsOfTheirMaterials) {
  const auto plies = [](const std::string& loss, const std::string& laminate) {
    return "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4\n"
           "MAT8,3,1.35+11,1.+10,.3,5.+9,5.+9,4.+9,1600.\n,,,,,,,,\n," +
           loss + "\nPCOMP,1,,,,,," + laminate + "\n,3,.001,0.,,3,.001,90.\n";
  };
  const ImportedModel model = read_text(plies(".02", ""));
  EXPECT_EQ(model.materials.at(0).loss, 0.02);
  EXPECT_TRUE(model.warnings.empty());
  const ImportedModel other = read_text(plies("", ".03"));
  EXPECT_EQ(other.materials.at(0).loss, 0.0);
  ASSERT_EQ(other.warnings.size(), 1u);
  EXPECT_THAT(other.warnings[0], AllOf(HasSubstr("PCOMP's GE"), HasSubstr("line 9")));
  EXPECT_THAT(refusal(plies("-.02", "")),
              HasSubstr("MAT8 3 has the damping GE -0.02; it must be at least 0"));
}

TEST(NastranDeck, RefusalsNameFileLineAndRemedy) {
  const std::string grids = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n";
  EXPECT_THAT(refusal(grids + "CTETRA,1,1,1,2,3,9\n"), HasSubstr("deck.bdf, line 5: node 9 does not exist"));
  EXPECT_THAT(refusal(grids + "CTETRA,1,1,1,2,3,4,1\n"),
              HasSubstr("CTETRA 1 has 1 of its 6 mid-side nodes; all or none"));
  EXPECT_THAT(refusal(grids + "GRID,1,,0.,0.,0.\n"), HasSubstr("is given twice"));
  EXPECT_THAT(refusal(grids + "PSOLID,2,7\nCTETRA,1,2,1,2,3,4\n"), HasSubstr("material 7 is not defined"));
  EXPECT_THAT(refusal(grids + "MAT1,7,2.+11,,.3\nPSOLID,2,7\nCTETRA,1,1,1,2,3,4\n"),
              HasSubstr("PSOLID 1 of CTETRA 1 is not defined"));
  EXPECT_THAT(refusal(grids + "CTETRA,1,1,1,2,3,x\n"),
              HasSubstr("field 7 of CTETRA is \"X\" where a whole number is wanted"));
  EXPECT_THAT(refusal("GRID,1,3,0.,0.,0.\nCTETRA,1,1,1,2,3,4\n"),
              HasSubstr("coordinate system 3 is not defined"));
  EXPECT_THAT(refusal(grids), HasSubstr("not Nastran bulk data?"));
  EXPECT_THAT(refusal(grids + "RBE2,1,1,127,2\nCTETRA,1,1,1,2,3,4\n"), HasSubstr("only the digits 1 to 6"));
}

}  // namespace
}  // namespace flexura::mesh
