// A channel with a tilted ellipse in it, in any unit of length; here the longer axis of the ellipse is 1.
//   gmsh -2 body.geo
SetFactory("OpenCASCADE");
length = 6;  height = 3;
x = 1.5;  y = 1.5;               // middle of the ellipse
a = 0.5;  b = 0.2;               // its half-axes
tilt = 30 * Pi / 180;            // nose up: the flow comes from the left

Rectangle(1) = {0, 0, 0, length, height};
Disk(2) = {x, y, 0, a, b};
Rotate {{0, 0, 1}, {x, y, 0}, -tilt} { Surface{2}; }
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };

// Boxes find the curves of each side; what lies in none of them is the body.
eps = 1e-6;
inlet() = Curve In BoundingBox {-eps, -eps, -eps, eps, height + eps, eps};
outlet() = Curve In BoundingBox {length - eps, -eps, -eps, length + eps, height + eps, eps};
bottom() = Curve In BoundingBox {-eps, -eps, -eps, length + eps, eps, eps};
top() = Curve In BoundingBox {-eps, height - eps, -eps, length + eps, height + eps, eps};
body() = Curve In BoundingBox {x - 2*a, y - 2*a, -eps, x + 2*a, y + 2*a, eps};

Physical Curve("inlet") = {inlet()};
Physical Curve("outlet") = {outlet()};
Physical Curve("sides") = {bottom(), top()};
Physical Curve("body") = {body()};
Physical Surface("fluid") = {3};

// Lengths of the edges: far from the body, and on it.
MeshSize{:} = 0.25;
MeshSize{PointsOf{Curve{body()};}} = 0.04;
