// Half of a table of two pads, below the ends of the cylinder that is lifted: the gripper passes between them.
// Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");
top = -31.2;                // y, 0.2 mm below the cylinder
Box(1) = {22.5, top - 2, 36, 7, 2, 32};
t = 1e-3;
upper() = Surface In BoundingBox{22.5 - t, top - t, 36 - t, 29.5 + t, top + t, 68 + t};
sides() = Boundary{ Volume{1}; };
sides() -= {upper()};
Physical Surface("top") = {upper()};
Physical Surface("sides") = {sides()};
Mesh.MeshSizeMax = 10;
