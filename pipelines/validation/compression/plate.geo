// A quarter of the upper plate, 0.02 mm above the cylinder. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");
level = 15.02;              // z
edge = 90;                  // of the quarter: the cylinder becomes wider
t = 1e-3;
Box(1) = {0, 0, level, edge, edge, 2};
lower() = Surface In BoundingBox{-t, -t, level - t, edge + t, edge + t, level + t};
others() = Boundary{ Volume{1}; };
others() -= {lower()};
Physical Surface("lower") = {lower()};
Physical Surface("others") = {others()};
Mesh.MeshSizeMax = 100;
