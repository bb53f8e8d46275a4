// A channel 2.2 x 0.41 with a cylinder of diameter 0.1, the geometry of the Schaefer-Turek benchmark (1996).
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 2.2, 0.41};
Disk(2) = {0.2, 0.2, 0, 0.05};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
eps = 1e-6;
inlet() = Curve In BoundingBox {-eps, -eps, -eps, eps, 0.41 + eps, eps};
outlet() = Curve In BoundingBox {2.2 - eps, -eps, -eps, 2.2 + eps, 0.41 + eps, eps};
bottom() = Curve In BoundingBox {-eps, -eps, -eps, 2.2 + eps, eps, eps};
top() = Curve In BoundingBox {-eps, 0.41 - eps, -eps, 2.2 + eps, 0.41 + eps, eps};
cylinder() = Curve In BoundingBox {0.1, 0.1, -eps, 0.3, 0.3, eps};
Physical Curve("inlet") = {inlet()};
Physical Curve("outlet") = {outlet()};
Physical Curve("walls") = {bottom(), top()};
Physical Curve("cylinder") = {cylinder()};
Physical Surface("fluid") = {3};
MeshSize{:} = 0.05;
MeshSize{PointsOf{Curve{cylinder()};}} = 0.0125;
