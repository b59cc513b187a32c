// Half of a worm: a box with rounded edges and a row of closed air chambers nearer to its belly,
// z = 0, cut in its plane of symmetry, y = 0. x points forward, z up. Lengths in millimetres:
// --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {8, Name "Longest edge"} ];       // --set h=4

n = 5;                      // chambers
pitch = 32;                 // of the row
wide = 26;                  // chambers: along the worm,
side = 5;                   // walls: to the side,
belly = 4;                  // below,
over = 9;                   // above
inside = 5;                 // radius of the chambers' edges
end = 7;                    // walls at both ends
width = 36;                 // of the whole
height = 28;
round = 8;                  // radius of the edges

length = (n - 1) * pitch + wide + 2 * end;
t = 1e-3;

Box(1) = {-length / 2, -width / 2, 0, length, width, height};
edges() = {};
For y In {-1:1:2}
  For z In {0:1}
    edges() += Curve In BoundingBox{-length / 2 - t, y * width / 2 - t, z * height - t, length / 2 + t, y * width / 2 + t, z * height + t};
  EndFor
EndFor
body() = Fillet{1}{edges()}{round};
For i In {1:n}
  Box(100 + i) = {(i - (n + 1) / 2) * pitch - wide / 2, -width / 2 + side, belly, wide, width - 2 * side, height - belly - over};
  edges() = Abs(Boundary{ Boundary{ Volume{100 + i}; } });
  air() = Fillet{100 + i}{Unique(edges())}{inside};
  body() = BooleanDifference{ Volume{body()}; Delete; }{ Volume{air()}; Delete; };
EndFor
Box(200) = {-length, -width, -height, 2 * length, width, 3 * height};
half() = BooleanDifference{ Volume{body()}; Delete; }{ Volume{200}; Delete; };

// Faces by where they are.
w = width / 2 + t;
cut() = Surface In BoundingBox{-length, -t, -t, length, t, height + t};
rear() = Surface In BoundingBox{-length / 2 - t, -w, -t, -length / 2 + t, w, height + t};
front() = Surface In BoundingBox{length / 2 - t, -w, -t, length / 2 + t, w, height + t};
back() = Surface In BoundingBox{-length / 2 - t, -w, height - round - t, length / 2 + t, w, height + t};
skin() = Abs(Boundary{ Volume{half()}; });
skin() -= {cut(), rear(), front(), back()};
For i In {1:n}
  at = (i - (n + 1) / 2) * pitch;
  wall~{i}() = Surface In BoundingBox{at - wide / 2 - t, -t, belly - t, at + wide / 2 + t, w - side, height - over + t};
  wall~{i}() -= {cut()};
  skin() -= {wall~{i}()};
  Physical Surface(Sprintf("chamber %g", i)) = {wall~{i}()};
EndFor

Physical Surface("cut") = {cut()};
Physical Surface("rear") = {rear()};
Physical Surface("front") = {front()};
Physical Surface("back") = {back()};
Physical Surface("belly") = {skin()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromCurvature = 40 / h;        // edges around a full circle
