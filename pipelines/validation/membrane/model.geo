// Disc of 2 mm, clamped around its edge; a rigid disc is glued on its middle from above. It bends
// sharply at the clamp and at the edge of the rigid disc: edges are shortest there.
// Lengths in millimetres.
SetFactory("OpenCASCADE");

DefineConstant[
    h = {6, Name "Longest edge"},
    edge = {2, Name "Shortest edge, at the clamp and at the edge of the rigid disc"}
];

radius = 70;
glued = 25.4;       // radius of the rigid disc
thickness = 2;

Cylinder(1) = {0, 0, 0, 0, 0, thickness, radius};
Disk(10) = {0, 0, thickness, glued};
BooleanFragments{ Volume{1}; Delete; }{ Surface{10}; Delete; }

t = 1e-3;
disc() = Surface In BoundingBox{-glued - t, -glued - t, thickness - t, glued + t, glued + t, thickness + t};
top() = Surface In BoundingBox{-radius - t, -radius - t, thickness - t, radius + t, radius + t, thickness + t};
top() -= {disc()};
air() = Surface In BoundingBox{-radius - t, -radius - t, -t, radius + t, radius + t, t};
clamped() = Boundary{ Volume{:}; };
clamped() -= {disc(), top(), air()};

Physical Surface("clamped") = {clamped()};
Physical Surface("disc") = {disc()};
Physical Surface("air") = {air()};
Physical Surface("top") = {top()};

bends() = Boundary{ Surface{top(0)}; };
Field[1] = Distance;
Field[1].CurvesList = {bends()};
Field[1].Sampling = 200;
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = edge;
Field[2].DistMin = 1;
Field[2].SizeMax = h;
Field[2].DistMax = 1 + 2 * (h - edge);
Background Field = 2;
Mesh.MeshSizeMax = h;
