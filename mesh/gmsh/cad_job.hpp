// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "mesh/gmsh/cad_file.hpp"
#include "mesh/gmsh/job.hpp"

// What solids and sheets of CAD files share: the question, and the answer in our own words.
namespace flexura::mesh {

Job first_job(const CadOptions& options, const CadFile& file, CadReport& report);

Eigen::Vector3d vector_of(const std::array<double, 3>& a);

/// Solids, faces and area.
void fill_report(const ResultRecord& record, CadReport& report);

/// To read a file and describe its faces takes a second for each MB: 20 s and 100 times that are not
/// slow but endless, as with a damaged surface whose area is sought for ever.
double listing_limit_s(const std::filesystem::path& file);

/// Named CAD faces become sets.
void add_named_sets(const std::vector<Face>& faces, Mesh& mesh);

}  // namespace flexura::mesh
