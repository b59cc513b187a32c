// A slice of a walker: an arch on two legs, each with an air chamber, in plane strain. x points
// forward, z up, y across the slice. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {2.8, Name "Longest edge"} ];        // --set h=1.6

depth = 2.5;                // of the slice
width = 40;                 // over both legs
height = 24;
gap = 16;                  // between the legs
arch = 9;                   // height of the gap
wide = 4.4;                 // chambers: width,
low = 3;                    // lower and
high = 17;
outside = 2.8;               // wall on the outer side of a leg
round = 2;                 // radius of the outline's edges

t = 1e-3;
Box(1) = {-width / 2, 0, 0, width, depth, height};
Box(2) = {-gap / 2, 0, -height, gap, depth, height + arch};
outline() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };
edges() = {};
For x In {-1:1:2}
  For z In {0:1}
    edges() += Curve In BoundingBox{x * width / 2 - t, -t, z * height - t, x * width / 2 + t, depth + t, z * height + t};
  EndFor
  edges() += Curve In BoundingBox{x * gap / 2 - t, -t, -t, x * gap / 2 + t, depth + t, t};
  edges() += Curve In BoundingBox{x * gap / 2 - t, -t, arch - t, x * gap / 2 + t, depth + t, arch + t};
EndFor
arch() = Fillet{1}{edges()}{round};

For x In {-1:1:2}
  leg = 10 + x;
  Box(leg) = {x * (width / 2 - outside - wide / 2) - wide / 2, 0, low, wide, depth, high - low};
  edges() = {};
  For s In {-1:1:2}
    For z In {low:high:high - low}
      at = x * (width / 2 - outside - wide / 2) + s * wide / 2;
      edges() += Curve In BoundingBox{at - t, -t, z - t, at + t, depth + t, z + t};
    EndFor
  EndFor
  air() = Fillet{leg}{edges()}{0.9 * wide / 2};
  arch() = BooleanDifference{ Volume{arch()}; Delete; }{ Volume{air()}; Delete; };
EndFor

// Faces by where they are.
w = width / 2 + t;
For x In {-1:1:2}
  at = x * (width / 2 - outside - wide / 2);
  wall~{1 + x}() = Surface In BoundingBox{at - wide / 2 - t, -t, low - t, at + wide / 2 + t, depth + t, high + t};
EndFor
rear() = wall_0();
front() = wall_2();
cut() = Surface In BoundingBox{-w, -t, -t, w, t, height + t};
cut() += Surface In BoundingBox{-w, depth - t, -t, w, depth + t, height + t};
back() = Surface In BoundingBox{-w, -t, height - t, w, depth + t, height + t};
outer() = Abs(Boundary{ Volume{arch()}; });
outer() -= {rear(), front(), cut(), back()};

Physical Surface("rear") = {rear()};
Physical Surface("front") = {front()};
Physical Surface("cut") = {cut()};
Physical Surface("back") = {back()};
Physical Surface("outer") = {outer()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromCurvature = 8;
