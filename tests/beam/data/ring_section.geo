// A planar face for the section solver: an ellipse of 80 x 40 mm with a similar hole of half its size, in the plane
// y-z.  Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The committed STEP file was written by  gmsh -parse_and_exit ring_section.geo  (gmsh 4.8.4, OpenCASCADE 7.6).
SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 40, 20};
Disk(2) = {0, 0, 0, 20, 10};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Rotate {{1, 1, 1}, {0, 0, 0}, 2*Pi/3} { Surface{3}; }
Save "ring_section.step";
