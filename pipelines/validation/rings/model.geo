// A quarter of the disc of ../membrane. Two rings of a stiffer silicone are in its thickness, around
// the rigid disc: radii 33.4 ± 5 and 46.4 ± 5. Their places on the upper face have tags. Edges are short
// throughout, as everything bends at the rings.
// Lengths in millimetres.
SetFactory("OpenCASCADE");

DefineConstant[
    h = {2.5, Name "Longest edge"}
];

thickness = 2;
radii[] = {25.4, 28.4, 38.4, 41.4, 51.4, 70};

Cylinder(1) = {0, 0, 0, 0, 0, thickness, radii[5], Pi/2};
For i In {0:4}
    Circle(100 + i) = {0, 0, thickness, radii[i], 0, Pi/2};
EndFor
BooleanFragments{ Volume{1}; Delete; }{ Curve{100:104}; Delete; }

// on the upper face, from the disc outward
t = 1e-3;
r = radii[0];
disc() = Surface In BoundingBox{-t, -t, thickness - t, r + t, r + t, thickness + t};
r = radii[1];
free() = Surface In BoundingBox{-t, -t, thickness - t, r + t, r + t, thickness + t};
free() -= {disc()};
r = radii[2];
inner() = Surface In BoundingBox{-t, -t, thickness - t, r + t, r + t, thickness + t};
inner() -= {disc(), free()};
r = radii[3];
gap() = Surface In BoundingBox{-t, -t, thickness - t, r + t, r + t, thickness + t};
gap() -= {disc(), free(), inner()};
r = radii[4];
outer() = Surface In BoundingBox{-t, -t, thickness - t, r + t, r + t, thickness + t};
outer() -= {disc(), free(), inner(), gap()};
r = radii[5];
rim() = Surface In BoundingBox{-t, -t, thickness - t, r + t, r + t, thickness + t};
rim() -= {disc(), free(), inner(), gap(), outer()};
air() = Surface In BoundingBox{-t, -t, -t, r + t, r + t, t};
cutx() = Surface In BoundingBox{-t, -t, -t, t, r + t, thickness + t};
cuty() = Surface In BoundingBox{-t, -t, -t, r + t, t, thickness + t};
clamped() = CombinedBoundary{ Volume{:}; };
clamped() -= {disc(), free(), inner(), gap(), outer(), rim(), air(), cutx(), cuty()};

Physical Surface("clamped") = {clamped()};
Physical Surface("disc") = {disc()};
Physical Surface("air") = {air()};
Physical Surface("rings") = {inner(), outer()};
Physical Surface("top") = {free(), gap(), rim()};
Physical Surface("cut-x") = {cutx()};
Physical Surface("cut-y") = {cuty()};

Mesh.MeshSizeMax = h;
