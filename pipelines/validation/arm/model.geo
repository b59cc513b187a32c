// Arm with four chambers around a hollow square core, hanging: the tip at z = 0, the clamped
// end, where the chambers are open, above. Lengths in millimetres.
SetFactory("OpenCASCADE");

DefineConstant[
    h = {4, Name "Longest edge"},
    rib = {2.27, Name "Thickness of the ribs"},
    more = {0, Name "Added to outer wall and wall of the core, into the chambers"},
    wound = {0, Name "1: the outside has a name of its own, for thread"}
];

length = 102;
end = 6.93;             // closed end at the tip
outer = 22.22;          // radius
outer_wall = 2.03 + more;
core = 10.11 / Sqrt(2); // half of the side of the core
core_wall = 2.27 + more;

square = core + core_wall;
inside = outer - outer_wall;
high = length - end;

Cylinder(1) = {0, 0, 0, 0, 0, length, outer};
Box(2) = {-core, -core, end, 2 * core, 2 * core, high};

// The chambers: a ring between square and circle, without the ribs along its diagonals.
Cylinder(3) = {0, 0, end, 0, 0, high, inside};
Box(4) = {-square, -square, end - 1, 2 * square, 2 * square, high + 2};
Box(5) = {-2 * outer, -rib / 2, end - 1, 4 * outer, rib, high + 2};
Rotate {{0, 0, 1}, {0, 0, 0}, Pi / 4} { Volume{5}; }
Box(6) = {-2 * outer, -rib / 2, end - 1, 4 * outer, rib, high + 2};
Rotate {{0, 0, 1}, {0, 0, 0}, -Pi / 4} { Volume{6}; }
chambers() = BooleanDifference{ Volume{3}; Delete; }{ Volume{4, 5, 6}; Delete; };
body() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2, chambers()}; Delete; };

t = 1e-3;
clamped() = Surface In BoundingBox{-outer - t, -outer - t, length - t, outer + t, outer + t, length + t};
tip() = Surface In BoundingBox{-outer - t, -outer - t, -t, outer + t, outer + t, t};
chamber() = Surface In BoundingBox{square - t, -inside, end - t, inside + t, inside, length + t};
rest() = Boundary{ Volume{body()}; };
rest() -= {clamped(), tip(), chamber()};
If (wound)
    outside() = {};
    For s In {0 : #rest() - 1}
        box() = BoundingBox Surface{rest(s)};
        If (box(3) > outer - 1e-3 || box(0) < -outer + 1e-3 || box(4) > outer - 1e-3 || box(1) < -outer + 1e-3)
            outside() += rest(s);
        EndIf
    EndFor
    rest() -= {outside()};
    Physical Surface("outside") = {outside()};
EndIf

Physical Surface("clamped") = {clamped()};
Physical Surface("tip") = {tip()};
Physical Surface("chamber") = {chamber()};
Physical Surface("rest") = {rest()};

Mesh.MeshSizeMax = h;
