// Connecting rod of the steam engine.  Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Lengths in mm.  Big end bore on the z axis, small end bore parallel to it at x = 300.
// The committed conrod.step was written by:  gmsh -parse_and_exit conrod.geo   (gmsh 4.8.4, OpenCASCADE 7.6)
SetFactory("OpenCASCADE");
Geometry.OCCBoundsUseStl = 1;

length = 300;                            // between the bores
big_bore = 25;   big_outer = 42;   big_width = 36;
small_bore = 15; small_outer = 27; small_width = 32;  // width over the bosses
small_body = 24; small_boss = 22;                     // width of the eye itself, outer radius of its bosses
shank = 20;      web = 7;        flange = 6;          // thickness (z) of flanges and web, height (y) of a flange
height_big = 48; height_small = 34;                   // shank height (y) at the two bore axes
joint_fillet = 14; pocket_fillet = 4; floor_fillet = 2.5;

// The two eyes and the tapered shank, one solid.
Cylinder(1) = {0, 0, -big_width/2, 0, 0, big_width, big_outer};
Cylinder(2) = {length, 0, -small_body/2, 0, 0, small_body, small_outer};
Point(101) = {0, -height_big/2, -shank/2};
Point(102) = {length, -height_small/2, -shank/2};
Point(103) = {length, height_small/2, -shank/2};
Point(104) = {0, height_big/2, -shank/2};
Line(101) = {101, 102}; Line(102) = {102, 103}; Line(103) = {103, 104}; Line(104) = {104, 101};
Curve Loop(101) = {101, 102, 103, 104};
Plane Surface(101) = {101};
blank() = Extrude{0, 0, shank}{ Surface{101}; };
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2}; Volume{blank(1)}; Delete; };

// Fillets where the flanges run into the eyes: the four edges along z between them.
x_big = 30; x_small = length - 15; 
joint() = Curve In BoundingBox{x_big, -height_big, -shank/2-0.1, big_outer+1, height_big, shank/2+0.1};
joint() += Curve In BoundingBox{length-small_outer-1, -height_small, -shank/2-0.1, x_small, height_small, shank/2+0.1};
upright() = {};
For i In {0 : #joint()-1}
  b() = BoundingBox Curve{joint(i)};
  If (b(5)-b(2) > shank-0.5 && b(3)-b(0) < 0.1 && b(4)-b(1) < 0.1)
    upright() += joint(i);
  EndIf
EndFor
Printf("upright edges: %g", #upright());
rod() = Fillet{10}{upright()}{joint_fillet};

// The two pockets that make the I-section: rounded in plan, rounded at the floor.
pocket_start = 56; pocket_end = 262;
slope = (height_small - height_big) / 2 / length;
half_start = height_big/2 + slope*pocket_start - flange;
half_end = height_big/2 + slope*pocket_end - flange;
Point(201) = {pocket_start, -half_start, web/2}; Point(202) = {pocket_end, -half_end, web/2};
Point(203) = {pocket_end, half_end, web/2};      Point(204) = {pocket_start, half_start, web/2};
Line(201) = {201, 202}; Line(202) = {202, 203}; Line(203) = {203, 204}; Line(204) = {204, 201};
Curve Loop(201) = {201, 202, 203, 204};
Plane Surface(201) = {201};
block() = Extrude{0, 0, big_width}{ Surface{201}; };
upright() = {};
floor_edge() = {};
edge() = Abs(Boundary{ Surface{ Abs(Boundary{ Volume{block(1)}; }) }; });
edge() = Unique(edge());
For i In {0 : #edge()-1}
  b() = BoundingBox Curve{edge(i)};
  If (b(5)-b(2) > big_width-0.5)
    upright() += edge(i);
  EndIf
EndFor
pocket() = Fillet{block(1)}{upright()}{pocket_fillet};
edge() = Unique(Abs(Boundary{ Surface{ Abs(Boundary{ Volume{pocket(0)}; }) }; }));
For i In {0 : #edge()-1}
  b() = BoundingBox Curve{edge(i)};
  If (b(5) < web/2+0.01)
    floor_edge() += edge(i);
  EndIf
EndFor
Printf("floor edges: %g", #floor_edge());
pocket() = Fillet{pocket(0)}{floor_edge()}{floor_fillet};
mirrored() = Symmetry{0, 0, 1, 0}{ Duplicata{ Volume{pocket(0)}; } };

// Bosses and bores.
Cylinder(30) = {length, 0, -small_width/2, 0, 0, small_width, small_boss};
BooleanUnion(31) = { Volume{rod(0)}; Delete; }{ Volume{30}; Delete; };
Cylinder(40) = {0, 0, -big_width, 0, 0, 2*big_width, big_bore};
Cylinder(41) = {length, 0, -big_width, 0, 0, 2*big_width, small_bore};
BooleanDifference(50) = { Volume{31}; Delete; }{ Volume{pocket(0), mirrored(0), 40, 41}; Delete; };
left() = Volume{:};
Printf("volumes left: %g", #left());
For i In {0 : #left()-1}
  Printf("volume %g", left(i));
  b() = BoundingBox Volume{left(i)};
  Printf("%g %g %g  %g %g %g", b(0), b(1), b(2), b(3), b(4), b(5));
EndFor
Save "conrod.step";
