// Half of a bellows gripper: narrow chambers in a row on a floor, joined by a channel, cut in its plane
// of symmetry, x = 0. Filled with air, the chambers widen, the floor does not, and the gripper curls
// towards the face of its floor, y = 0. z points from the base to the tip. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
  n = {7, Name "Chambers"}
  h = {4, Name "Longest edge"}
];

floor = 5;                  // thickness
fold = 2.6;                 // walls of the chambers that face each other,
wall = 4;                   // all others
long = 9.5;                 // of a chamber, outside
gap = 2.5;                  // between chambers
wide = 24;
high = 19;                  // of the chambers above the floor
channel = 3;                // its width and height
base = 14;                  // solid, before the first chamber
tip = 5;                    // solid, behind the last one
pitch = long + gap;
end = base + n * pitch - gap;
more = tip - fold;          // the last chamber has a thick wall at its free end

// Silicone: the strip along the floor, the solid base, and the chambers.
Box(1) = {0, 0, 0, wide / 2, floor + channel + wall, end};
Box(2) = {0, 0, 0, wide / 2, floor + high, base - gap};
For i In {0 : n - 1}
  Box(10 + i) = {0, 0, base + i * pitch, wide / 2, floor + high, long + ((i == n - 1) ? more : 0)};
EndFor
Box(3) = {0, 0, end - 1, wide / 2, floor + channel + wall, more + 1};
solid() = BooleanUnion{ Volume{1}; Delete; }{ Volume{2, 3, 10 : 9 + n}; Delete; };

// Air: the channel, open in the base, and the chambers.
Box(100) = {-1, floor, -1, 1 + channel / 2, channel, end - 2};
For i In {0 : n - 1}
  Box(110 + i) = {-1, floor, base + i * pitch + fold, 1 + wide / 2 - wall, high - wall, long - 2 * fold};
EndFor
air() = BooleanUnion{ Volume{100}; Delete; }{ Volume{110 : 109 + n}; Delete; };
gripper() = BooleanDifference{ Volume{solid()}; Delete; }{ Volume{air()}; Delete; };

// Faces by where they are.
t = 1e-3;
w = wide / 2 + t;
top = end + tip;
seat() = Surface In BoundingBox{-t, -t, -t, w, floor + high + t, t};
face() = Surface In BoundingBox{-t, -t, -t, w, t, top + t};
cut() = Surface In BoundingBox{-t, -t, -t, t, floor + high + t, top + t};
cavity() = Surface In BoundingBox{-t, floor - t, -t, w - wall, floor + high - wall + 2*t, end - fold + t};
outer() = Abs(Boundary{ Volume{gripper()}; });
For i In {0 : n}            // the box holds the valleys between the chambers, too
  z = base + i * pitch - gap;
  cavity() -= {Surface In BoundingBox{-t, floor + channel + wall - t, z - t, w, 100, z + gap + t}};
EndFor
cavity() -= {cut(), seat()};
outer() -= {seat(), face(), cavity(), cut()};

Physical Surface("seat") = {seat()};
Physical Surface("cut") = {cut()};
Physical Surface("cavity") = {cavity()};
Physical Surface("face") = {face()};
Physical Surface("outer") = {outer()};

Mesh.MeshSizeMax = h;
