// A unit cube with a pair of periodic faces and a ball inside as a region of its own.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Sphere(2) = {0.5, 0.5, 0.5, 0.3};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
eps = 1e-6;
left() = Surface In BoundingBox {-eps, -eps, -eps, eps, 1 + eps, 1 + eps};
right() = Surface In BoundingBox {1 - eps, -eps, -eps, 1 + eps, 1 + eps, 1 + eps};
Periodic Surface {right()} = {left()} Translate {1, 0, 0};
Physical Surface("left") = {left()};
Physical Surface("right") = {right()};
Physical Volume("ball") = {2};
Physical Volume("all") = {2, 3};
MeshSize{:} = 0.6;
