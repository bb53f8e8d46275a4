// The cube [-1, 1]^3 with a sphere of radius 0.5 about the origin as a surface of the mesh, fine about it and coarse at the walls.
SetFactory("OpenCASCADE");
Box(1) = {-1, -1, -1, 2, 2, 2};
Sphere(2) = {0, 0, 0, 0.5};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
eps = 1e-6;
left() = Surface In BoundingBox {-1 - eps, -1 - eps, -1 - eps, -1 + eps, 1 + eps, 1 + eps};
right() = Surface In BoundingBox {1 - eps, -1 - eps, -1 - eps, 1 + eps, 1 + eps, 1 + eps};
bottom() = Surface In BoundingBox {-1 - eps, -1 - eps, -1 - eps, 1 + eps, -1 + eps, 1 + eps};
top() = Surface In BoundingBox {-1 - eps, 1 - eps, -1 - eps, 1 + eps, 1 + eps, 1 + eps};
back() = Surface In BoundingBox {-1 - eps, -1 - eps, -1 - eps, 1 + eps, 1 + eps, -1 + eps};
front() = Surface In BoundingBox {-1 - eps, -1 - eps, 1 - eps, 1 + eps, 1 + eps, 1 + eps};
sphere() = Surface In BoundingBox {-0.6, -0.6, -0.6, 0.6, 0.6, 0.6};
Physical Surface("left") = {left()};
Physical Surface("right") = {right()};
Physical Surface("bottom") = {bottom()};
Physical Surface("top") = {top()};
Physical Surface("back") = {back()};
Physical Surface("front") = {front()};
Physical Surface("walls") = {left(), right(), bottom(), top(), back(), front()};
Physical Volume("ball") = {2};
Physical Volume("fluid") = {3};
// Edges of 0.1 up to 0.1 from the sphere, of 0.5 from 0.5 on.
Field[1] = Distance;
Field[1].FacesList = {sphere()};
Field[1].NNodesByEdge = 60;
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = 0.1;
Field[2].SizeMax = 0.5;
Field[2].DistMin = 0.1;
Field[2].DistMax = 0.5;
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
