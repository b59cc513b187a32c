// Half of the gripper of ../model.geo with places for what holds it together: a sheet of cloth in its floor, and
// cloth around its chambers. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
  n = {7, Name "Chambers"}
  h = {4, Name "Longest edge"}
  fold = {2.6, Name "Walls of the chambers that face each other"}
  wall = {3, Name "All other walls of the chambers"}
  last = {0.5, Name "What they are thicker in the last chamber"}
  long = {9.5, Name "Length of a chamber, outside"}
  gap = {2.5, Name "Between chambers"}
  sheet = {2, Name "Height of the cloth in the floor"}
  floor = {5, Name "Thickness of the floor"}
];

wide = 24;
high = 19;                  // of the chambers above the floor
channel = 3;                // its width and height
base = 14;                  // solid, before the first chamber
tip = 5;                    // solid, behind the last one
pitch = long + gap;
end = base + n * pitch - gap;
more = tip - fold;          // the last chamber has a thick wall at its free end
top = end + tip;

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
For i In {0 : n - 1}        // a last one as large as the others would have its end for fab's flat wall, not the floor
  thick = wall + ((i == n - 1) ? last : 0);
  Box(110 + i) = {-1, floor, base + i * pitch + fold, 1 + wide / 2 - thick, high - thick, long - 2 * fold};
EndFor
air() = BooleanUnion{ Volume{100}; Delete; }{ Volume{110 : 109 + n}; Delete; };
gripper() = BooleanDifference{ Volume{solid()}; Delete; }{ Volume{air()}; Delete; };

// The cloth divides the floor; rectangles on the sides mark what is covered.
Box(200) = {-1, -1, -1, wide, 1 + sheet, 2 * top};
below() = BooleanIntersection{ Volume{gripper()}; }{ Volume{200}; };
above() = BooleanDifference{ Volume{gripper()}; Delete; }{ Volume{200}; Delete; };
For i In {0 : n - 1}
  z = base + i * pitch;
  p = newp; Point(p) = {wide / 2, 0, z}; Point(p + 1) = {wide / 2, floor + high, z};
  Point(p + 2) = {wide / 2, floor + high, z + long}; Point(p + 3) = {wide / 2, 0, z + long};
  l = newl; Line(l) = {p, p + 1}; Line(l + 1) = {p + 1, p + 2}; Line(l + 2) = {p + 2, p + 3}; Line(l + 3) = {p + 3, p};
  Curve Loop(500 + i) = {l, l + 1, l + 2, l + 3}; Plane Surface(500 + i) = {500 + i};
EndFor
BooleanFragments{ Volume{below(), above()}; Delete; }{ Surface{500 : 499 + n}; Delete; }

// Faces by where they are.
t = 1e-3;
w = wide / 2 + t;
far = floor + high + t;
seat() = Surface In BoundingBox{-t, -t, -t, w, far, t};
face() = Surface In BoundingBox{-t, -t, -t, w, t, top + t};
cloth() = Surface In BoundingBox{-t, sheet - t, -t, w, sheet + t, top + t};
cut() = Surface In BoundingBox{-t, -t, -t, t, far, top + t};
cavity() = Surface In BoundingBox{-t, floor - t, -t, w - wall, far - wall + t, end - fold + t};
wound() = {};
For i In {0 : n - 1}
  z = base + i * pitch;
  wound() += {Surface In BoundingBox{w - 2 * t, -t, z - t, w, far, z + long + t}};
  wound() += {Surface In BoundingBox{-t, far - 2 * t, z - t, w, far, z + long + ((i == n - 1) ? more : 0) + t}};
EndFor
For i In {0 : n}            // the box holds the valleys between the chambers, too
  z = base + i * pitch - gap;
  cavity() -= {Surface In BoundingBox{-t, floor + channel + wall - t, z - t, w, 100, z + gap + t}};
EndFor
cavity() -= {cut(), seat()};
outer() = CombinedBoundary{ Volume{:}; };
outer() = Abs(outer());
outer() -= {seat(), face(), cavity(), cut(), wound()};

Physical Surface("seat") = {seat()};
Physical Surface("cut") = {cut()};
Physical Surface("cavity") = {cavity()};
Physical Surface("face") = {face()};
Physical Surface("wound") = {wound()};      // sides and tops of the chambers, below the cloth around them
Physical Surface("outer") = {outer()};
Physical Surface("cloth") = {cloth()};      // inside

Mesh.MeshSizeMax = h;
