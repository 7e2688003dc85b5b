// The shafts of the table as solids.  Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Lengths in mm.  The committed STEP files were written by
//   gmsh -parse_and_exit -setnumber length 1000 shaft.geo;  mv shaft.step shaft_1m.step
//   gmsh -parse_and_exit -setnumber length 2000 shaft.geo;  mv shaft.step shaft_2m.step     (gmsh 4.8.4, OpenCASCADE 7.6)
SetFactory("OpenCASCADE");
If (!Exists(length)) length = 1000; EndIf
Cylinder(1) = {0, 0, 0, length, 0, 0, 125};
Save "shaft.step";
