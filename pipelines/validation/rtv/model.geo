// A cube of 10 mm, of which three faces are planes of symmetry: the strain is the same everywhere. Lengths in millimetres.
SetFactory("OpenCASCADE");
a = 10;
t = 1e-3;
Box(1) = {0, 0, 0, a, a, a};
x() = Surface In BoundingBox{-t, -t, -t, t, a + t, a + t};
y() = Surface In BoundingBox{-t, -t, -t, a + t, t, a + t};
z() = Surface In BoundingBox{-t, -t, -t, a + t, a + t, t};
pulled() = Surface In BoundingBox{-t, -t, a - t, a + t, a + t, a + t};
free() = Boundary{ Volume{1}; };
free() -= {x(), y(), z(), pulled()};
Physical Surface("cut-x") = {x()};
Physical Surface("cut-y") = {y()};
Physical Surface("cut-z") = {z()};
Physical Surface("pulled") = {pulled()};
Physical Surface("free") = {free()};
Mesh.MeshSizeMax = a;
