// A portal of three curves and an arch over it, as wires for beam members.
// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The committed files were written by  gmsh -parse_and_exit portal.geo  and
// gmsh -parse_and_exit -setnumber mesh 1 portal.geo  (gmsh 4.8.4, OpenCASCADE 7.6).  Lengths in mm.
SetFactory("OpenCASCADE");
If (!Exists(mesh)) mesh = 0; EndIf
Point(1) = {0, 0, 0};  Point(2) = {0, 0, 3000};  Point(3) = {4000, 0, 3000};  Point(4) = {4000, 0, 0};
Point(5) = {2000, 0, 3000};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {4, 3};
Circle(4) = {2000, 0, 3000, 2000, 0, Pi};
Rotate {{1, 0, 0}, {2000, 0, 3000}, Pi/2} { Curve{4}; }
If (!mesh)
  Delete { Point{5}; }
  Save "portal.step";
EndIf
If (mesh)
  Physical Curve("legs") = {1, 3};
  Physical Curve("roof") = {2, 4};
  Mesh.MeshSizeMax = 500;
  Mesh 1;
  Save "portal.msh";
EndIf
