// A channel with a cylinder, in any unit of length. Its mesh, obstacle.msh, is made by
//   gmsh -2 obstacle.geo
// and a finer one by `gmsh -2 -clscale 0.5 obstacle.geo`.
SetFactory("OpenCASCADE");
length = 2.2;  height = 0.41;
x = 0.2;  y = 0.2;  radius = 0.05;

Rectangle(1) = {0, 0, 0, length, height};
Disk(2) = {x, y, 0, radius};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };

// Every part of the boundary has a name, which the scene uses; gmsh finds it by a box around it.
eps = 1e-6;
inlet() = Curve In BoundingBox {-eps, -eps, -eps, eps, height + eps, eps};
outlet() = Curve In BoundingBox {length - eps, -eps, -eps, length + eps, height + eps, eps};
bottom() = Curve In BoundingBox {-eps, -eps, -eps, length + eps, eps, eps};
top() = Curve In BoundingBox {-eps, height - eps, -eps, length + eps, height + eps, eps};
obstacle() = Curve In BoundingBox {x - 2*radius, y - 2*radius, -eps, x + 2*radius, y + 2*radius, eps};
Physical Curve("inlet") = {inlet()};
Physical Curve("outlet") = {outlet()};
Physical Curve("bed") = {bottom(), top()};
Physical Curve("obstacle") = {obstacle()};
// So has the domain: gmsh writes only what has a name.
Physical Surface("fluid") = {3};

// Edges of the triangles: far from the obstacle, and on it.
MeshSize{:} = 0.04;
MeshSize{PointsOf{Curve{obstacle()};}} = 0.008;
