// Half of the rigid cylinder to grip, off the gripper's face. A thinner one about the same axis is
// what the face aims at. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");
DefineConstant[ h = {4.5, Name "Longest edge"} ];
DefineConstant[ radius = {14, Name "Radius"} ];        // --set radius=12: the target
place = 52;                 // height of its axis
axis = -17;                 // y of its axis
DefineConstant[ length = {40, Name "Length"} ];         // --set length=60: the one to lift
Cylinder(1) = {0, axis, place, length / 2, 0, 0, radius};
t = 1e-3;
near() = Surface In BoundingBox{-t, -100, -100, t, 100, 100};
far() = Surface In BoundingBox{length / 2 - t, -100, -100, length / 2 + t, 100, 100};
side() = Boundary{ Volume{1}; };
side() -= {near(), far()};
Physical Surface("cut") = {near()};
Physical Surface("end") = {far()};
Physical Surface("side") = {side()};
Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 150 / h;       // edges around a full circle
