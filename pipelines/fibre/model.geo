// A bending actuator that is wound: a half-round tube with a sheet of paper on its flat side, a thread around
// both, and a skin over the thread. x goes along the actuator from the end that is held, z up from the paper.
// README.md has the sources of the sizes. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
  long = {80, Name "Length of the chamber"},    // --set long=160
  skin = {1, Name "Skin over the thread"},      // --set skin=0: the core alone, which is cast first
  h = {2.6, Name "Longest edge"}
];

a = 8;                          // radius of the chamber, half-round
wall = 2;                       // around it
floor = 2;                      // below it
cap = 6;                        // the closed end

end = long + cap;

// A half-round bar on a rectangle: p() of radius r, from the height low.
Macro Bar
  Cylinder(900) = {0, 0, floor, end, 0, 0, r};
  Box(901) = {0, -r, floor, end, 2 * r, r};
  round() = BooleanIntersection{ Volume{900}; Delete; }{ Volume{901}; Delete; };
  Box(902) = {0, -r, low, end, 2 * r, floor - low};
  p() = BooleanUnion{ Volume{round()}; Delete; }{ Volume{902}; Delete; };
Return

r = a + wall; low = 0;
Call Bar;
core() = p();
r = a + wall + skin; low = -skin;
Call Bar;
body() = p();

// The chamber, open at the held end.
Cylinder(910) = {-1, 0, floor, long + 1, 0, 0, a};
Box(911) = {-1, -a, floor, long + 1, 2 * a, a};
air() = BooleanIntersection{ Volume{910}; Delete; }{ Volume{911}; Delete; };
body() = BooleanDifference{ Volume{body()}; Delete; }{ Volume{air()}; };
core() = BooleanDifference{ Volume{core()}; Delete; }{ Volume{air()}; Delete; };
If (skin > 0)
  BooleanFragments{ Volume{body()}; Volume{core()}; Delete; }{}
Else
  Recursive Delete { Volume{core()}; }
EndIf

// Faces by where they are; what is none of them is outside.
t = 1e-3;
y = a + wall + skin + t;
top = floor + a + wall + skin + t;
seat() = Surface In BoundingBox{-t, -y, -skin - t, t, y, top};
tip() = Surface In BoundingBox{end - t, -y, -skin - t, end + t, y, top};
cavity() = Surface In BoundingBox{-t, -a - t, floor - t, long + t, a + t, floor + a + t};
cavity() -= {seat()};
paper() = Surface In BoundingBox{-t, -y, -t, end + t, y, t};
wound() = Surface In BoundingBox{-t, -y + skin, -t, end + t, y - skin, top - skin};
wound() -= {seat(), tip(), paper(), cavity()};
outer() = CombinedBoundary{ Volume{:}; };
outer() -= {seat(), tip(), cavity()};
If (skin == 0)
  outer() -= {paper()};
EndIf

Physical Surface("seat") = {seat()};
Physical Surface("cavity") = {cavity()};
Physical Surface("tip") = {tip()};
Physical Surface("outer") = {outer()};
If (skin > 0)
  Physical Surface("paper") = {paper()};    // between core and skin: the flat side
  Physical Surface("wound") = {wound()};    // and all around above it
Else
  Physical Surface("flat") = {paper()};     // where the paper will be
EndIf

// The chamber's triangles are the same with and without skin: the pins of both molds then stand at the same places.
far() = Surface In BoundingBox{long - t, -a - t, floor - t, long + t, a + t, floor + a + t};
sides() = cavity();
sides() -= {far()};
Transfinite Surface {sides()};

Mesh.MeshSizeMax = h;
