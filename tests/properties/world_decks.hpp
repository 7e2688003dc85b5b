// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <string>

#include "reduce/part/part_mesh.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::reduce {

class WorldDecks : public mbs::test::TestFolder {
 protected:
  PartInput part(const std::filesystem::path& path) const {
    PartInput input;
    input.name = "deck", input.where = "deck";
    input.format = path.extension() == ".inp" ? PartFormat::abaqus : PartFormat::nastran;
    input.cad.path = path;
    return input;
  }
  PartMesh load(const std::string& deck, const std::string& name) const {
    return load_part_mesh(part(file(deck, name)), {});
  }
  static InterfaceInput interface_at(int node) {
    InterfaceInput f{
        .name = fmt::format("at {}", node), .tie = Tie::node, .directions = {0, 1, 2}, .where = "deck"};
    f.rule = mesh::NodesRule{.labels = {node}};
    return f;
  }
};

inline constexpr const char* kBrick =
    "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
    "*ELEMENT,TYPE=C3D8,ELSET=E\n1,1,2,3,4,5,6,7,8\n";

}  // namespace flexura::reduce
