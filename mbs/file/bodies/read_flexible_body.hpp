// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/preparation_cache.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/superelement/superelement.hpp"

/// The automatic preparation of a flexible body: from what its table says and what acts on it.
///
/// Fidelities: fidelities.cpp.
///
/// Where eigenmodes are dropped, `attachments` adds response modes for the interfaces that joints,
/// constraints or forces act on.
namespace flexura::mbs {

/// Keys of a body that hold for superelements.
std::vector<input::Key> flexible_body_keys();

/// True where the body's table asks for stresses.
bool wants_stress(const input::Section& s);

/// True where it asks for nodes of the surface.
bool wants_surface_points(const input::Section& s);

/// Those; `se` with its surface, and with the shapes there of a body that deforms (else null).  Throws
/// InputError.
std::shared_ptr<const SurfacePoints> read_surface_points(const input::Section& s,
                                                         const superelement::Superelement& se,
                                                         const ModalData* body);

/// The stresses its table asks for; `se` with its stress modes and surface.  Throws InputError.
std::shared_ptr<const StressField> read_stress_field(
    const input::Section& s, const std::shared_ptr<const superelement::Superelement>& se,
    const ModalData& body, const std::vector<BodyNode>& nodes);

/// Builds the body; joints and forces of `d` are already there and its markers on interfaces have the
/// interface's index as node, those on the nodes of `linked` the numbers behind.  Notes for the user are
/// appended.  `on_surface` (n_se x any) are loads p_se of forces that act on its surface.  Throws InputError.
std::shared_ptr<const FlexibleBody> prepare_flexible_body(
    const input::Section& s, const superelement::Superelement& se, const std::vector<BodyNode>& linked,
    const Eigen::MatrixXd& on_surface, const MechanismDescription& d, int body,
    std::vector<std::string>& notes, PreparationCache& cache);

}  // namespace flexura::mbs
