// Arm with three parallel chambers at 120 degrees around a solid core. It stands on its base, z = 0,
// where each chamber ends in a bore for a tube; its tip is closed. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {5.5, Name "Longest edge"} ];   // --set h=4

length = 90;
radius = 14;
wall = 2.2;                 // between chambers and outside
core = 4.5;                 // radius of the core
rib = 3;                    // thickness of the ribs between chambers
base = 8;                   // thickness of the base, and
end = 5;                    // of the closed tip
bore = 3;                   // radius of the bores, and
at = 8.1;                   // their distance from the axis
t = 1e-3;

inside = radius - wall;
high = length - base - end;

// A ring between core and wall, cut by three ribs.
Cylinder(2) = {0, 0, base, 0, 0, high, inside};
Cylinder(3) = {0, 0, base - 1, 0, 0, high + 2, core};
For i In {1:3}
  Box(3 + i) = {0, -rib / 2, base - 1, 2 * radius, rib, high + 2};
  Rotate {{0, 0, 1}, {0, 0, 0}, Pi / 2 + Pi / 3 + 2 * Pi / 3 * (i - 1)} { Volume{3 + i}; }
EndFor
rooms() = BooleanDifference{ Volume{2}; Delete; }{ Volume{3:6}; Delete; };
For i In {1:3}
  turn = Pi / 2 + 2 * Pi / 3 * (i - 1);
  Cylinder(20 + i) = {at * Cos(turn), at * Sin(turn), 0, 0, 0, base + 1, bore};
EndFor
air() = BooleanUnion{ Volume{rooms()}; Delete; }{ Volume{21:23}; Delete; };
Cylinder(100) = {0, 0, 0, 0, 0, length, radius};
all() = BooleanFragments{ Volume{100}; Delete; }{ Volume{air()}; Delete; };

// Chambers by where they are, their walls without the discs at the mouths of the bores.
ch1() = Volume In BoundingBox{-radius, t, -t, radius, radius, length};
ch2() = Volume In BoundingBox{-radius, -radius, -t, -t, radius, length};
ch3() = Volume In BoundingBox{t, -radius, -t, radius, radius, length};
mouths() = {};
For i In {1:3}
  mouths() += Surface In BoundingBox{at * Cos(Pi / 2 + 2 * Pi / 3 * (i - 1)) - bore - t, at * Sin(Pi / 2 + 2 * Pi / 3 * (i - 1)) - bore - t, -t,
    at * Cos(Pi / 2 + 2 * Pi / 3 * (i - 1)) + bore + t, at * Sin(Pi / 2 + 2 * Pi / 3 * (i - 1)) + bore + t, t};
EndFor
wall1() = Abs(Boundary{ Volume{ch1()}; });  wall1() -= mouths();
wall2() = Abs(Boundary{ Volume{ch2()}; });  wall2() -= mouths();
wall3() = Abs(Boundary{ Volume{ch3()}; });  wall3() -= mouths();
arm() = all();
arm() -= {ch1(), ch2(), ch3()};
Recursive Delete { Volume{ch1(), ch2(), ch3()}; }

base() = Surface In BoundingBox{-radius - t, -radius - t, -t, radius + t, radius + t, t};
tip() = Surface In BoundingBox{-radius - t, -radius - t, length - t, radius + t, radius + t, length + t};
skin() = Abs(Boundary{ Volume{arm()}; });
skin() -= {base(), tip(), wall1(), wall2(), wall3()};
Physical Surface("ch1") = {wall1()};
Physical Surface("ch2") = {wall2()};
Physical Surface("ch3") = {wall3()};
Physical Surface("base") = {base()};
Physical Surface("tip") = {tip()};
Physical Surface("skin") = {skin()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 60 / h;        // edges around a full circle
