// A straight tube with fibres in the outer half of its wall, to see what their angle does. x goes along it from
// the end that is held. Its ends are square, so that they have sides, by which its twist is measured. Lengths in
// millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[
  long = {60, Name "Length between the ends"},
  h = {2.4, Name "Longest edge"}
];

a = 6;                          // radius of the chamber
wall = 2;
layer = 1;                      // of the wall, which has fibres
end = 6;                        // length of an end
b = a + wall;

Box(1) = {-end, -b, -b, end, 2 * b, 2 * b};
Box(2) = {long, -b, -b, end, 2 * b, 2 * b};
Cylinder(3) = {0, 0, 0, long, 0, 0, b - layer};
Cylinder(4) = {0, 0, 0, long, 0, 0, b};
Cylinder(5) = {-end - 1, 0, 0, end + long + 1, 0, 0, a};
layer() = BooleanDifference{ Volume{4}; Delete; }{ Volume{3}; };
rest() = BooleanDifference{ Volume{1, 3}; Delete; }{ Volume{5}; Delete; };
rest() += {2};
BooleanFragments{ Volume{layer(), rest()}; Delete; }{}

// Faces by where they are; what is none of them is outside.
t = 1e-3;
c = b + t;
seat() = Surface In BoundingBox{-end - t, -c, -c, -end + t, c, c};
foot() = Surface In BoundingBox{-end - t, b - t, -c, t, c, c};
tip() = Surface In BoundingBox{long + end - t, -c, -c, long + end + t, c, c};
side() = Surface In BoundingBox{long - t, b - t, -c, long + end + t, c, c};
cavity() = Surface In BoundingBox{-end - t, -a - t, -a - t, long + t, a + t, a + t};
outer() = CombinedBoundary{ Volume{:}; };
outer() -= {seat(), foot(), tip(), side(), cavity()};
fibres() = Volume In BoundingBox{-t, -c, -c, long + t, c, c};
bound() = CombinedBoundary{ Volume{rest()}; };
Printf("layer %g rest %g", #layer(), #rest());

Physical Surface("seat") = {seat()};
Physical Surface("foot") = {foot()};
Physical Surface("tip") = {tip()};
Physical Surface("side") = {side()};
Physical Surface("cavity") = {cavity()};
Physical Surface("outer") = {outer()};
Physical Volume("layer") = {layer()};

Mesh.MeshSizeMax = h;
