// An eighth of a cylinder between plates: a quarter around its axis, of which the lower end is the middle.
// Lengths in millimetres.
SetFactory("OpenCASCADE");

DefineConstant[
    radius = {25, Name "Radius"},
    height = {30, Name "Height"},
    h = {4, Name "Longest edge"}
];

Cylinder(1) = {0, 0, 0, 0, 0, height / 2, radius, Pi/2};

t = 1e-3;
plate() = Surface In BoundingBox{-t, -t, height / 2 - t, radius + t, radius + t, height / 2 + t};
middle() = Surface In BoundingBox{-t, -t, -t, radius + t, radius + t, t};
cutx() = Surface In BoundingBox{-t, -t, -t, t, radius + t, height / 2 + t};
cuty() = Surface In BoundingBox{-t, -t, -t, radius + t, t, height / 2 + t};
side() = CombinedBoundary{ Volume{:}; };
side() -= {plate(), middle(), cutx(), cuty()};

Physical Surface("plate") = {plate()};
Physical Surface("side") = {side()};
Physical Surface("middle") = {middle()};
Physical Surface("cut-x") = {cutx()};
Physical Surface("cut-y") = {cuty()};

Mesh.MeshSizeMax = h;
