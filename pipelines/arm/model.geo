// Arm with three parallel chambers at 120 degrees around its axis. It stands on its base, z = 0, where
// each chamber ends in a bore for a tube; its tip is closed. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {7, Name "Longest edge"} ];     // --set h=4

length = 120;
radius = 12;
from_axis = 6.8;            // of the chambers
chamber = 3.6;              // radius of a chamber
bore = 2.7;                 // radius of its bore
base = 8;                   // thickness of the base, and
end = 5;                    // of the closed tip
t = 1e-3;

Cylinder(1) = {0, 0, 0, 0, 0, length, radius};
For i In {1:3}
  x(i) = from_axis * Cos(Pi / 2 + 2 * Pi / 3 * (i - 1));
  y(i) = from_axis * Sin(Pi / 2 + 2 * Pi / 3 * (i - 1));
  Cylinder(10 * i) = {x(i), y(i), base, 0, 0, length - base - end, chamber};
  Cylinder(10 * i + 1) = {x(i), y(i), -1, 0, 0, base + 2, bore};
EndFor
air() = BooleanUnion{ Volume{10, 20, 30}; Delete; }{ Volume{11, 21, 31}; Delete; };
arm() = BooleanDifference{ Volume{1}; Delete; }{ Volume{air()}; Delete; };

// Faces by where they are; the skin is what is neither end nor chamber.
base() = Surface In BoundingBox{-radius - t, -radius - t, -t, radius + t, radius + t, t};
tip() = Surface In BoundingBox{-radius - t, -radius - t, length - t, radius + t, radius + t, length + t};
skin() = Boundary{ Volume{arm()}; };
skin() -= {base(), tip()};
For i In {1:3}
  wall() = Surface In BoundingBox{x(i) - chamber - t, y(i) - chamber - t, -t, x(i) + chamber + t, y(i) + chamber + t, length - t};
  skin() -= {wall()};
  Physical Surface(Sprintf("ch%g", i)) = {wall()};
EndFor
Physical Surface("base") = {base()};
Physical Surface("tip") = {tip()};
Physical Surface("skin") = {skin()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 56 / h;        // edges around a full circle
