// One segment of a worm: a box with rounded long edges and a closed air chamber nearer to its
// belly, z = 0. x points forward, z up. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {4.5, Name "Longest edge"} ];       // --set h=3

length = 40;
width = 36;
height = 30;
round = 8;                  // radius of the long edges
end = 6;                    // walls: towards the neighbours,
side = 5;                   // to the sides,
belly = 4;                  // below,
back = 9;                   // above
inside = 4;                 // radius of the chamber's edges

t = 1e-3;

Box(1) = {-length / 2, -width / 2, 0, length, width, height};
edges() = {};
For y In {-1:1:2}
  For z In {0:1}
    edges() += Curve In BoundingBox{-length / 2 - t, y * width / 2 - t, z * height - t, length / 2 + t, y * width / 2 + t, z * height + t};
  EndFor
EndFor
body() = Fillet{1}{edges()}{round};

Box(100) = {-length / 2 + end, -width / 2 + side, belly, length - 2 * end, width - 2 * side, height - belly - back};
edges() = Abs(Boundary{ Boundary{ Volume{100}; } });
air() = Fillet{100}{Unique(edges())}{inside};
segment() = BooleanDifference{ Volume{body()}; Delete; }{ Volume{air()}; Delete; };

// Faces by where they are; the skin is what is neither end nor chamber.
w = width / 2 + t;
rear() = Surface In BoundingBox{-length / 2 - t, -w, -t, -length / 2 + t, w, height + t};
front() = Surface In BoundingBox{length / 2 - t, -w, -t, length / 2 + t, w, height + t};
cavity() = Surface In BoundingBox{-length / 2 + end - t, -width / 2 + side - t, belly - t, length / 2 - end + t, width / 2 - side + t, height - back + t};
skin() = Abs(Boundary{ Volume{segment()}; });
skin() -= {rear(), front(), cavity()};

Physical Surface("rear") = {rear()};
Physical Surface("front") = {front()};
Physical Surface("cavity") = {cavity()};
Physical Surface("skin") = {skin()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromCurvature = 54 / h;        // edges around a full circle
