// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Draws engine.step: a one-cylinder engine of 17 bodies, 11 distinct parts. The crank turns about y, the piston
// slides along z; the crank stands 60 degrees behind the top.
#include <cmath>
#include <iostream>
#include <numbers>

#include "cases/assembly/drawing.hpp"

namespace {

using namespace drawing;

constexpr double kCrank = 25.0, kRod = 100.0, kAngle = std::numbers::pi / 3.0;
const gp_Dir kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

// A bolt along -z with its head above z = 0.
TopoDS_Shape bolt(double radius, double length) {
  return cylinder({0, 0, -length}, kZ, radius, length) + cylinder({0, 0, 0}, kZ, 1.8 * radius, 2.0 * radius);
}

TopoDS_Shape block() {
  TopoDS_Shape shape = box({-45, -45, 60}, {45, 45, 200}) + box({-45, -75, -45}, {45, -45, 200});
  shape = shape - cylinder({0, 0, 60}, kZ, 30.0, 140.0);   // the bore
  shape = shape - cylinder({0, -75, 0}, kY, 15.02, 30.0);  // the main bearing
  for (const double x : {-37.0, 37.0})
    for (const double y : {-37.0, 37.0}) shape = shape - cylinder({x, y, 170}, kZ, 4.0, 30.0);
  return shape;
}

TopoDS_Shape head() {
  TopoDS_Shape shape = box({-45, -75, 200}, {45, 45, 215});
  for (const double x : {-37.0, 37.0})
    for (const double y : {-37.0, 37.0}) shape = shape - cylinder({x, y, 200}, kZ, 4.0, 15.0);
  return shape;
}

// The crank at its top: pin on +z.
TopoDS_Shape crankshaft() {
  TopoDS_Shape shape = cylinder({0, -75, 0}, kY, 15.0, 30.0) + cylinder({0, -45, 0}, kY, 48.0, 15.0);
  shape = shape + cylinder({0, -30, kCrank}, kY, 14.0, 20.0);
  shape = shape + cylinder({0, -10, kCrank}, kY, 10.0, 20.0);
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 3.0;
    shape = shape - cylinder({9 * std::sin(angle), -75, 9 * std::cos(angle)}, kY, 2.5, 17.0);
  }
  for (const double x : {-6.0, 6.0}) shape = shape - cylinder({x, -2, kCrank}, kY, 1.5, 12.0);
  return shape;
}

TopoDS_Shape flywheel() {
  TopoDS_Shape shape = cylinder({0, -95, 0}, kY, 60.0, 20.0);
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 3.0;
    shape = shape - cylinder({9 * std::sin(angle), -95, 9 * std::cos(angle)}, kY, 2.5, 20.0);
  }
  return shape;
}

TopoDS_Shape retainer() {
  TopoDS_Shape shape = cylinder({0, 10, 0}, kY, 14.0, 4.0);
  for (const double x : {-6.0, 6.0}) shape = shape - cylinder({x, 10, 0}, kY, 1.5, 4.0);
  return shape;
}

TopoDS_Shape rod() {
  TopoDS_Shape shape = cylinder({0, -10, 0}, kY, 18.0, 20.0) + cylinder({0, -10, kRod}, kY, 13.0, 20.0);
  shape = shape + box({-7, -6, 12}, {7, 6, kRod - 10});
  shape = shape - cylinder({0, -10, 0}, kY, 10.01, 20.0);
  return shape - cylinder({0, -10, kRod}, kY, 8.01, 20.0);
}

TopoDS_Shape piston() {
  TopoDS_Shape shape = cylinder({0, 0, -20}, kZ, 29.95, 45.0);
  shape = shape - box({-20, -10.5, -20}, {20, 10.5, 15});
  return shape - cylinder({0, -40, 0}, kY, 8.0, 80.0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: draw_engine FILE.step\n";
    return 2;
  }
  Assembly engine("engine");
  const TDF_Label crank_unit = engine.group("crank unit"), piston_unit = engine.group("piston unit");
  const TDF_Label m8 = engine.part("bolt M8", bolt(4.0, 40.0)), m5 = engine.part("bolt M5", bolt(2.5, 35.0)),
                  m3 = engine.part("bolt M3", bolt(1.5, 14.0));
  engine.place(engine.part("block", block(), 2700.0, "#8899AA"), TopLoc_Location());
  engine.place(engine.part("head", head(), 2700.0, "#AABBCC"), TopLoc_Location());
  for (const double x : {-37.0, 37.0})
    for (const double y : {-37.0, 37.0}) engine.place(m8, at({x, y, 215}));
  // The crank unit is drawn with its pin on +z and placed turned.
  engine.place(crank_unit, engine.part("crankshaft", crankshaft(), 7850.0, "#CC6633"), TopLoc_Location());
  engine.place(crank_unit, engine.part("flywheel", flywheel(), 7200.0, "#444444"), TopLoc_Location());
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 3.0;  // heads towards -y
    engine.place(crank_unit, m5,
                 turned({9 * std::sin(angle), -95, 9 * std::cos(angle)}, kX, std::numbers::pi / 2));
  }
  engine.place(crank_unit, engine.part("retainer", retainer(), 7850.0), at({0, 0, kCrank}));
  for (const double x : {-6.0, 6.0})
    engine.place(crank_unit, m3, turned({x, 14, kCrank}, kX, -std::numbers::pi / 2));
  engine.place(crank_unit, turned({0, 0, 0}, kY, kAngle));
  const double x = kCrank * std::sin(kAngle), z = kCrank * std::cos(kAngle), lean = -std::asin(x / kRod);
  engine.place(engine.part("connecting rod", rod(), 7850.0, "#33AA55"), turned({x, 0, z}, kY, lean));
  engine.place(piston_unit, engine.part("piston", piston(), 2700.0, "#DDDDDD"), TopLoc_Location());
  engine.place(piston_unit, engine.part("piston pin", cylinder({0, -25, 0}, kY, 8.0, 50.0), 7850.0),
               TopLoc_Location());
  engine.place(piston_unit, at({0, 0, z + std::sqrt(kRod * kRod - x * x)}));
  engine.write(argv[1]);
  return 0;
}
