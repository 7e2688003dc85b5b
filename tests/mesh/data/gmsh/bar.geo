// A bent bar of quarter-ring shape: extruded hexahedra, wedges on one side; for reader tests.
SetFactory("Built-in");
Point(1) = {1,0,0}; Point(2) = {2,0,0}; Point(3) = {2,1,0}; Point(4)={1,1,0};
Line(1)={1,2}; Line(2)={2,3}; Line(3)={3,4}; Line(4)={4,1};
Curve Loop(1)={1,2,3,4}; Plane Surface(1)={1};
Transfinite Surface{1}; Transfinite Curve{1,3}=3; Transfinite Curve{2,4}=2;
If (quads) Recombine Surface{1}; EndIf
o() = Extrude {0,0,3} { Surface{1}; Layers{2}; Recombine; };
Physical Volume("bar") = {o(1)};
Physical Surface("foot") = {1};
Physical Surface("top") = {o(0)};
Physical Point(7) = {1};
