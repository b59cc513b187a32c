// The cylinder to grip, in front of the gripper's face with a gap. A smaller one about the same
// axis is what the face aims at. Lengths in millimetres: --unit mm.
SetFactory("OpenCASCADE");

DefineConstant[ h = {4.5, Name "Longest edge"} ];
DefineConstant[ radius = {14, Name "Radius"} ];         // --set radius=11: the target

place = 32;                 // height of its axis
axis = -15;                 // y of its axis: a gap of 1 mm before a cylinder of radius 14
length = 44;

Cylinder(1) = {-length / 2, axis, place, length, 0, 0, radius};

t = 1e-3;
near() = Surface In BoundingBox{-length / 2 - t, -100, -100, -length / 2 + t, 100, 100};
far() = Surface In BoundingBox{length / 2 - t, -100, -100, length / 2 + t, 100, 100};
side() = Boundary{ Volume{1}; };
side() -= {near(), far()};

Physical Surface("ends") = {near(), far()};
Physical Surface("side") = {side()};

Mesh.MeshSizeMax = h;
Mesh.MeshSizeFromCurvature = 90 / h;        // edges around a full circle
