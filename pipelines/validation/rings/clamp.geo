// A quarter of the ring that clamps the membrane from above: its inner edge is rounded. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
    edge = {1, Name "Radius of the edge"}
];

inner = 70;
level = 2.2;                // z: 0.2 mm above the membrane
width = 12;
height = 6;

Rectangle(1) = {inner, level, 0, width, height, edge};
Rotate{ {1, 0, 0}, {0, 0, 0}, Pi/2 }{ Surface{1}; }
Extrude{ {0, 0, 1}, {0, 0, 0}, Pi/2 }{ Surface{1}; }
all() = Boundary{ Volume{1}; };
Physical Surface("ring") = {all()};
Mesh.MeshSizeMax = 4;
Mesh.MeshSizeFromCurvature = 10;
