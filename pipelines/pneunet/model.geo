// A fast PneuNet: chambers in a row on a floor with paper in it. Dimensions of one chamber as in the
// Soft Robotics Toolkit, "Mold Design CAD Tutorial" of PneuNets bending actuators; it has 11 of them.
// x goes along the row from the end that is held, z up, the floor is at z = 0. Lengths in
// millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
  n = {4, Name "Chambers"}                  // --set n=11
  h = {2.6, Name "Longest edge"}
];

long = 8;  wide = 15;  high = 15;           // of a chamber, outside
side = 1;                                   // thickness of the walls that face each other
wall = 2;                                   // of all others
gap = 2;                                    // between chambers
channel = 2;                                // width and height
base = 2;                                   // thickness of the floor below the chambers
paper = 1;                                  // height of the paper in it
lead = 6;                                   // from the held end to the first chamber

pitch = long + gap;
end = lead + n * pitch - gap + wall - side; // the last chamber has a thick wall at its free end

// Silicone: the strip along the floor, and the chambers on it.
strip = channel + wall;
Box(1) = {0, -wide / 2, base, end, wide, strip};
For i In {0 : n - 1}
  more = (i == n - 1) ? wall - side : 0;
  Box(10 + i) = {lead + i * pitch, -wide / 2, base, long + more, wide, high};
EndFor
solid() = BooleanUnion{ Volume{1}; Delete; }{ Volume{10 : 9 + n}; Delete; };

// Air: the channel, open at the held end, and the chambers.
Box(100) = {-1, -channel / 2, base, end - wall + 1 - side, channel, channel};
For i In {0 : n - 1}
  Box(110 + i) = {lead + i * pitch + side, -wide / 2 + wall, base,
                  long - 2 * side, wide - 2 * wall, high - wall};
EndFor
air() = BooleanUnion{ Volume{100}; Delete; }{ Volume{110 : 109 + n}; Delete; };
top() = BooleanDifference{ Volume{solid()}; Delete; }{ Volume{air()}; Delete; };

// The floor, above the paper and below it; below in three parts, for the tags of its ends.
ends = 5;
Box(200) = {0, -wide / 2, paper, end, wide, base - paper};
Box(201) = {0, -wide / 2, 0, ends, wide, paper};
Box(202) = {ends, -wide / 2, 0, end - 2 * ends, wide, paper};
Box(203) = {end - ends, -wide / 2, 0, ends, wide, paper};
BooleanFragments{ Volume{top(), 200 : 203}; Delete; }{}

// Faces by where they are; what is none of them is outside. Faces between volumes are inside the
// body, the paper among them.
t = 1e-3;
y = wide / 2 + t;
seat() = Surface In BoundingBox{-t, -y, -t, t, y, base + strip + t};
tip() = Surface In BoundingBox{end - t, -y, -t, end + t, y, base + high + t};
paper() = Surface In BoundingBox{-t, -y, paper - t, end + t, y, paper + t};
cavity() = Surface In BoundingBox{-t, -y + wall, base - t, end - side, y - wall, base + high - wall + 2 * t};
root() = Surface In BoundingBox{-t, -y, -t, ends + t, y, t};
toe() = Surface In BoundingBox{end - ends - t, -y, -t, end + t, y, t};
marks() = Surface In BoundingBox{ends - t, -y, -t, ends + t, y, paper + t};
marks() += Surface In BoundingBox{end - ends - t, -y, -t, end - ends + t, y, paper + t};
outer() = CombinedBoundary{ Volume{:}; };
outer() -= {seat(), tip(), cavity(), root(), toe()};

Physical Surface("seat") = {seat()};
Physical Surface("cavity") = {cavity()};
Physical Surface("tip") = {tip()};
Physical Surface("root") = {root()};        // below the floor, where it is held
Physical Surface("toe") = {toe()};          // and at its free end
Physical Surface("outer") = {outer()};
Physical Surface("paper") = {paper()};
Physical Surface("marks") = {marks()};      // inside: where root and toe end, so that the mesh has edges there

Mesh.MeshSizeMax = h;
