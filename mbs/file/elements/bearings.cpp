// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>

#include "mbs/file/elements/element_types.hpp"
#include "mbs/forces/bearings/bearing_matrix.hpp"
#include "mbs/forces/bearings/journal_bearing.hpp"
#include "mbs/forces/bearings/rolling_bearing.hpp"

/// Bearings in a mechanism file.
namespace flexura::mbs {
namespace {

constexpr const char* housing = "marker F in the housing, its z axis that of the bearing";
constexpr const char* shaft = "marker M on the shaft, its z axis that about which it turns freely";

BearingMatrix::Matrix5 read_bearing_matrix(const input::Section& s, const char* key) {
  const Eigen::MatrixXd A = s.matrix(key);
  const bool has_turn = A.rows() == 6 && A.cols() == 6;
  if (!has_turn && (A.rows() != 5 || A.cols() != 5))
    s.refuse(key, "is neither 5 x 5 nor 6 x 6", "write its rows for x, y, z and the turns about x, y");
  if (has_turn && (!A.row(5).isZero(0.0) || !A.col(5).isZero(0.0)))
    s.refuse(key, "holds the turning about z", "its sixth row and column must be 0: the shaft turns freely");
  return A.topLeftCorner<5, 5>();
}

ForceType bearing_by_matrices() {
  using namespace input;
  return {"bearing",
          "A bearing by its stiffness and damping matrices: the shaft turns freely about z, as far as it "
          "likes, and is held "
          "in the other five directions.",
          {text("from", housing).required(), text("to", shaft).required(),
           matrix("stiffness_matrix",
                  "5 x 5 in SI units: x, y, z, tilts about x, y; of a fluid film it may be unsymmetric. A "
                  "sixth row and column "
                  "of zeros may stand beside it")
               .required(),
           matrix("damping_matrix", "the same of damping; its symmetric part must not put power in")},
          {{"force_x, force_y, force_z", "N", "on the body of `to`, in the axes of `from`"},
           {"torque_x, torque_y", "N*m", "on the body of `to`, in the axes of `from`"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const BearingMatrix::Matrix5 K = read_bearing_matrix(s, "stiffness_matrix");
            BearingMatrix::Matrix5 D = BearingMatrix::Matrix5::Zero();
            if (s.has("damping_matrix")) {
              D = read_bearing_matrix(s, "damping_matrix");
              const Eigen::SelfAdjointEigenSolver<BearingMatrix::Matrix5> of(D + D.transpose(),
                                                                             Eigen::EigenvaluesOnly);
              if (of.eigenvalues().minCoeff() < -1e-12 * of.eigenvalues().cwiseAbs().maxCoeff())
                s.refuse("damping_matrix", "puts power in along some motion",
                         "its symmetric part must not be negative");
            }
            return std::make_shared<BearingMatrix>(name, context.marker(s, "from"), context.marker(s, "to"),
                                                   K, D);
          }};
}

ForceType rolling_bearing() {
  using namespace input;
  return {"rolling_bearing",
          "A ball or roller bearing from its geometry: Hertz' contacts, the load distributed over the "
          "rolling elements. The shaft "
          "turns freely about z; the rolling elements stand still, the first on the x axis of F.",
          {text("from", housing).required(), text("to", shaft).required(),
           choice("kind", {"ball", "roller"}, "what rolls").or_default("ball"),
           integer("elements", "number of balls or rollers").required().at_least(3),
           quantity("diameter", dim::length, "of a ball or roller").required().above(0.0),
           quantity("pitch_diameter", dim::length, "of the circle of their centres").required().above(0.0),
           quantity("contact_angle", dim::angle,
                    "of angular contact: the bearing carries the shaft against its moving along + z; turn "
                    "both markers for the "
                    "other way. Without it a deep groove, or cylindrical rollers"),
           quantity("clearance", dim::length,
                    "radial, of the diameter; negative: interference. Not with balls of angular contact")
               .or_default("0 m"),
           quantity("groove_inner", dim::none, "radius of the inner groove over the balls' diameter")
               .or_default("0.52"),
           quantity("groove_outer", dim::none, "of the outer groove").or_default("0.52"),
           quantity("length", dim::length, "effective length of a roller").above(0.0),
           quantity("youngs_modulus", dim::pressure, "of balls and grooves; rollers are of steel")
               .or_default("206 GPa"),
           quantity("poissons_ratio", dim::none, "of balls and grooves").or_default("0.3"),
           quantity("damping", dim::damping, "against the shaft's centre moving, all ways")
               .or_default("0 N*s/m")
               .at_least(0.0),
           quantity("tilt_damping", dim::angular_damping, "against its tilting")
               .or_default("0 N*m*s/rad")
               .at_least(0.0)},
          {{"force_x, force_y, force_z", "N", "on the body of `to`, in the axes of `from`"},
           {"torque_x, torque_y", "N*m", "on the body of `to`, in the axes of `from`"},
           {"largest_load", "N", "of one rolling element"},
           {"loaded", "", "number of rolling elements that carry"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            RollingGeometry g;
            const bool is_ball = s.text("kind") == "ball";
            g.kind = is_ball ? RollingGeometry::Kind::ball : RollingGeometry::Kind::roller;
            g.count = s.integer("elements");
            g.diameter = s.quantity("diameter");
            g.pitch_diameter = s.quantity("pitch_diameter");
            g.clearance = s.quantity("clearance");
            if (s.has("contact_angle")) g.contact_angle = s.quantity("contact_angle");
            g.is_deep_groove = is_ball && !s.has("contact_angle");
            if (is_ball && !g.is_deep_groove && g.clearance != 0.0)
              s.refuse("clearance", "stands beside contact_angle",
                       "balls of angular contact have none; move a ring for preload");
            if (is_ball == s.has("length"))
              s.refuse(is_ball ? "length" : "", is_ball ? "is a roller's" : "length is missing",
                       is_ball ? "take the key away" : "a roller needs it");
            g.groove_inner = s.quantity("groove_inner");
            g.groove_outer = s.quantity("groove_outer");
            if (!is_ball) g.length = s.quantity("length");
            g.youngs_modulus = s.quantity("youngs_modulus");
            g.poissons_ratio = s.quantity("poissons_ratio");
            try {
              return std::make_shared<RollingBearing>(name, context.marker(s, "from"),
                                                      context.marker(s, "to"), g, s.quantity("damping"),
                                                      s.quantity("tilt_damping"));
            } catch (const input::InputError&) {
              throw;
            } catch (const std::invalid_argument& error) {
              s.refuse("", error.what(), "correct its geometry");
            }
          }};
}

ForceType journal_bearing() {
  using namespace input;
  return {"journal_bearing",
          "A plain bearing with a film of oil, Reynolds' equation of the short bearing (Ocvirk): load, "
          "whirl, squeeze, friction.",
          {text("from", "marker F in the sleeve, its z axis that of the bearing").required(),
           text("to", "marker M on the journal, its z axis that about which it turns").required(),
           quantity("radius", dim::length, "of the journal").required().above(0.0),
           quantity("length", dim::length, "of the bearing; the theory is for lengths up to the radius")
               .required()
               .above(0.0),
           quantity("clearance", dim::length, "radial: the sleeve's radius less the journal's")
               .required()
               .above(0.0),
           expression("viscosity", "of the oil, Pa s").required(),
           choice("film", {"half", "full"},
                  "half: no pressure below that around (cavitation); full: none of it, as of a flooded "
                  "squeeze film")
               .or_default("half")},
          {{"force_x, force_y", "N", "on the body of `to`, in the axes of `from`"},
           {"torque_z", "N*m", "on the body of `to` about its marker"},
           {"eccentricity", "", "of the journal, over the clearance"},
           {"thinnest_film", "m", "between journal and sleeve"},
           {"power_lost", "W", "in the film"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const JournalBearing::Geometry g{
                s.quantity("radius"), s.quantity("length"), s.quantity("clearance"),
                context.number(s, "viscosity"),
                s.text("film") == "half" ? JournalBearing::Film::half : JournalBearing::Film::full};
            if (!(g.viscosity > 0.0)) s.refuse("viscosity", "must be above 0");
            if (!(g.clearance < g.radius))
              s.refuse("clearance", "is not below the radius", "it is the film's thickness");
            return std::make_shared<JournalBearing>(name, context.marker(s, "from"), context.marker(s, "to"),
                                                    g);
          }};
}

}  // namespace

std::vector<ForceType> bearing_types() {
  return {bearing_by_matrices(), rolling_bearing(), journal_bearing()};
}

}  // namespace flexura::mbs
