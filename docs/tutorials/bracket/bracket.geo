// An angle bracket: a foot with two screw holes, a wall with a bearing bore, a rib between them.  Lengths in mm.
// The bracket.step beside it was written from this file by gmsh 4.8.4 (OpenCASCADE 7.6).
SetFactory("OpenCASCADE");
Box(1) = {0, -40, 0, 70, 80, 10};           // foot: lies on z = 0
Box(2) = {0, -40, 0, 10, 80, 90};           // wall: its back on x = 0
Point(101) = {10, -5, 10}; Point(102) = {60, -5, 10}; Point(103) = {10, -5, 40};
Line(101) = {101, 102}; Line(102) = {102, 103}; Line(103) = {103, 101};
Curve Loop(101) = {101, 102, 103}; Plane Surface(101) = {101};
rib() = Extrude{0, 10, 0}{ Surface{101}; };
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2, rib(1)}; Delete; };
Cylinder(20) = {-5, 0, 65, 25, 0, 0, 15};   // bearing bore, along x
Cylinder(21) = {45, -25, -5, 0, 0, 25, 5};  // screw holes, along z
Cylinder(22) = {45, 25, -5, 0, 0, 25, 5};
BooleanDifference(30) = { Volume{10}; Delete; }{ Volume{20, 21, 22}; Delete; };
