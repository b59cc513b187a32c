// Disc of 2 mm, clamped around its edge; a rigid disc is glued on its middle from above.
// Lengths in millimetres.
SetFactory("OpenCASCADE");

DefineConstant[ h = {5, Name "Longest edge"} ];

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

Mesh.MeshSizeMax = h;
