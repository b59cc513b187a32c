// A straight tube of three segments, each wound at angles of its own, with a strip of straight fibres below the
// winding on the lower side of the first and the last. x goes along it from the end that is held, z up. Lengths in
// millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
  segment = {30, Name "Length of a segment"},
  h = {3.6, Name "Longest edge"}
];

a = 6;                          // radius of the chamber
wall = 2;
layer = 1;                      // of the wall, outside, which is wound
under = 4.6;                    // strips are below this, in the inner half of the wall
cap = 4;                        // the closed end
b = a + wall;
m = b - layer;
long = 3 * segment;

For i In {0 : 2}
  Cylinder(10 + i) = {i * segment, 0, 0, segment, 0, 0, b};
  Cylinder(20 + i) = {i * segment, 0, 0, segment, 0, 0, m};
EndFor
Cylinder(30) = {0, 0, 0, segment, 0, 0, m};
Cylinder(31) = {2 * segment, 0, 0, segment, 0, 0, m};
Box(32) = {0, -b, -b, long, 2 * b, b - under};
strips() = BooleanIntersection{ Volume{30, 31}; Delete; }{ Volume{32}; Delete; };
Cylinder(40) = {long, 0, 0, cap, 0, 0, b};
Cylinder(50) = {-1, 0, 0, long + 1, 0, 0, a};
all() = BooleanFragments{ Volume{10 : 12, 20 : 22, strips(), 40}; Delete; }{};
BooleanDifference{ Volume{all()}; Delete; }{ Volume{50}; Delete; }

// Volumes and faces by where they are; what is none of the faces is outside.
t = 1e-3;
c = b + t;
For i In {0 : 2}
  x = i * segment;
  piece() = Volume In BoundingBox{x - t, -c, -c, x + segment + t, c, c};
  within() = Volume In BoundingBox{x - t, -m - t, -m - t, x + segment + t, m + t, m + t};
  piece() -= {within()};
  If (i == 0)
    first() = {piece()};
  ElseIf (i == 1)
    second() = {piece()};
  Else
    third() = {piece()};
  EndIf
EndFor
strip1() = Volume In BoundingBox{-t, -m - t, -m - t, segment + t, m + t, -under + t};
strip3() = Volume In BoundingBox{2 * segment - t, -m - t, -m - t, long + t, m + t, -under + t};
seat() = Surface In BoundingBox{-t, -c, -c, t, c, c};
tip() = Surface In BoundingBox{long + cap - t, -c, -c, long + cap + t, c, c};
cavity() = Surface In BoundingBox{-t, -a - t, -a - t, long + t, a + t, a + t};
outer() = CombinedBoundary{ Volume{:}; };
inside() = {cavity()};
inside() -= {outer()};          // sides of the strips
cavity() -= {inside()};
outer() -= {seat(), tip(), cavity()};

Physical Surface("seat") = {seat()};
Physical Surface("tip") = {tip()};
Physical Surface("cavity") = {cavity()};
Physical Surface("outer") = {outer()};
Physical Volume("first") = {first()};
Physical Volume("second") = {second()};
Physical Volume("third") = {third()};
Physical Volume("first-strip") = {strip1()};
Physical Volume("third-strip") = {strip3()};

Mesh.MeshSizeMax = h;
