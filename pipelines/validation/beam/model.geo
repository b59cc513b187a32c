// Cantilever: x from the free end to the clamped one, z up. Lengths in millimetres.
SetFactory("OpenCASCADE");

DefineConstant[ h = {6, Name "Longest edge"} ];

length = 100;
side = 30;
strip = 2;          // along the upper edge of the free end, for the weight

Box(1) = {0, 0, 0, length, side, side};
Rectangle(10) = {0, 0, side, strip, side};
BooleanFragments{ Volume{1}; Delete; }{ Surface{10}; Delete; }

t = 1e-3;
free_end() = Surface In BoundingBox{-t, -t, -t, t, side + t, side + t};
clamped() = Surface In BoundingBox{length - t, -t, -t, length + t, side + t, side + t};
weight() = Surface In BoundingBox{-t, -t, side - t, strip + t, side + t, side + t};
sides() = Boundary{ Volume{:}; };
sides() -= {free_end(), clamped(), weight()};

Physical Surface("free_end") = {free_end()};
Physical Surface("clamped") = {clamped()};
Physical Surface("weight") = {weight()};
Physical Surface("sides") = {sides()};

Mesh.MeshSizeMax = h;
