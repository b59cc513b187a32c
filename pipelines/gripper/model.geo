// Bellows gripper: half-round bellows on a thick floor. Filled with air, the bellows unfold,
// the floor does not, and the gripper curls towards the face of its floor, y = 0.
// z points from the base to the tip, x across. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {4.5, Name "Longest edge"} ];       // --set h=3.5

floor = 7;                  // thickness; the axis of the bellows is in its back
outer_crest = 16;           // radii
outer_valley = 11.5;
inner_crest = 10.5;
inner_valley = 5.5;
n = 7;                      // bellows
period = 12;
flat = 1.2;                 // half width of outer crests and inner valleys
edge = 1;                   // half width of outer valleys and inner crests
base = 14;                  // height of the first valley
tip = 6;                    // thickness of solid material at the tip
bore = 1.8;                 // radius of the inlet
ramp = period / 2 - flat - edge;
end = base + n * period;    // height of the last valley

// Half profiles in the plane y = floor, from the axis outwards: a zigzag between two levels.
Macro Corner
  Point(np) = {r, floor, z};
  corners() += {np};
  np += 1;
Return

Macro Profile
  first = newc;
  m = #corners() - 1;
  For i In {0:m}
    Line(first + i) = {corners(i), corners((i + 1) % (m + 1))};
  EndFor
  wire = newcl;
  Curve Loop(wire) = {first : first + m};
  face = news;
  Plane Surface(face) = {wire};
Return

np = 1;
corners() = {};
r = 0;  z = 0;  Call Corner;
r = outer_crest;  Call Corner;
For k In {0:n}
  z = base + k * period;
  z -= edge + ramp;  r = outer_crest;   Call Corner;
  z += ramp;         r = outer_valley;  Call Corner;
  z += 2 * edge;                        Call Corner;
  z += ramp;         r = outer_crest;   Call Corner;
EndFor
z += tip;  Call Corner;
r = 0;  Call Corner;
Call Profile;
outside = face;

corners() = {};
r = 0;  z = base - 6;  Call Corner;
r = inner_valley;  Call Corner;
For k In {0:n-1}
  z = base + k * period + flat;             Call Corner;
  z += ramp;         r = inner_crest;   Call Corner;
  z += 2 * edge;                        Call Corner;
  z += ramp;         r = inner_valley;  Call Corner;
EndFor
z = end + 2;  Call Corner;
r = 0;  Call Corner;
Call Profile;
inside = face;

back[] = Extrude { {0, 0, 1}, {0, floor, 0}, Pi } { Surface{outside}; };
right[] = Extrude {0, -floor, 0} { Surface{outside}; };
left[] = Symmetry {1, 0, 0, 0} { Duplicata { Volume{right[1]}; } };
body() = BooleanUnion{ Volume{back[1]}; Delete; }{ Volume{right[1], left[0]}; Delete; };

hollow[] = Extrude { {0, 0, 1}, {0, floor, 0}, Pi } { Surface{inside}; };
inlet = newv;
Cylinder(inlet) = {0, floor + 1 + bore, -1, 0, 0, base, bore};
air() = BooleanUnion{ Volume{hollow[1]}; Delete; }{ Volume{inlet}; Delete; };
gripper() = BooleanDifference{ Volume{body()}; Delete; }{ Volume{air()}; Delete; };
Recursive Delete { Surface{outside, inside}; }

// Faces by where they are.
t = 1e-3;
w = outer_crest + t;
top = end + edge + ramp + tip;
seat() = Surface In BoundingBox{-w, -t, -t, w, floor + w, t};
face() = Surface In BoundingBox{-w, -t, -t, w, t, top + t};
cavity() = Surface In BoundingBox{-inner_crest - t, floor - t, -t, inner_crest + t, floor + inner_crest + t, end + 2 + t};
outer() = Boundary{ Volume{gripper()}; };
outer() -= {seat(), face(), cavity()};

Physical Surface("seat") = {seat()};
Physical Surface("cavity") = {cavity()};
Physical Surface("face") = {face()};
Physical Surface("outer") = {outer()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeExtendFromBoundary = 0;        // short edges do not make large faces fine
Mesh.MeshSizeFromCurvature = 50 / h;        // edges around a full circle
