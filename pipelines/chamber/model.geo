// Validation chamber: two nested elliptic cylinders that do not share an axis, so
// that the wall varies continuously from 3 to 7 mm around them. Closed at both ends
// but for a bore in the end that is held. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {3, Name "Longest edge"} ];     // --set h=1.5; bends follow it

length = 60;
outer_a = 20;  outer_b = 16;    // half-axes along x and y
inner_a = 15;  inner_b = 11;
shift = 2;                      // of the inner axis along y
end = 5;                        // thickness of both ends
bore = 2.5;                     // radius

// An elliptic disc at height z, moved by dy.
Macro Disc
  Ellipse(n) = {0, dy, z, a, b};
  Curve Loop(n) = {n};
  Plane Surface(n) = {n};
Return

n = 1;  z = 0;    dy = 0;      a = outer_a;  b = outer_b;  Call Disc;
n = 2;  z = end;  dy = shift;  a = inner_a;  b = inner_b;  Call Disc;

body[] = Extrude {0, 0, length} { Surface{1}; };
hollow[] = Extrude {0, 0, length - 2 * end} { Surface{2}; };
Cylinder(100) = {0, shift, -1, 0, 0, end + 2, bore};
air() = BooleanUnion{ Volume{hollow[1]}; Delete; }{ Volume{100}; Delete; };
wall() = BooleanDifference{ Volume{body[1]}; Delete; }{ Volume{air()}; Delete; };

// Faces by where they are; what is neither end nor cavity is outside.
t = 1e-3;
fixed() = Surface In BoundingBox{-outer_a - t, -outer_b - t, -t, outer_a + t, outer_b + t, t};
tip() = Surface In BoundingBox{-outer_a - t, -outer_b - t, length - t, outer_a + t, outer_b + t, length + t};
cavity() = Surface In BoundingBox{-inner_a - t, shift - inner_b - t, -t, inner_a + t, shift + inner_b + t, length - end + t};
outer() = Boundary{ Volume{wall()}; };
outer() -= {fixed(), tip(), cavity()};

Physical Surface("fixed") = {fixed()};
Physical Surface("cavity") = {cavity()};
Physical Surface("outer") = {outer()};
Physical Surface("tip") = {tip()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 48 / h;    // edges around a full circle
