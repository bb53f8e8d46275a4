// The cube 2 x 2 x 2 with a ball of radius 0.5 in its middle as a region of its own.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 2, 2, 2};
Sphere(2) = {1, 1, 1, 0.5};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
eps = 1e-6;
left() = Surface In BoundingBox {-eps, -eps, -eps, eps, 2 + eps, 2 + eps};
right() = Surface In BoundingBox {2 - eps, -eps, -eps, 2 + eps, 2 + eps, 2 + eps};
bottom() = Surface In BoundingBox {-eps, -eps, -eps, 2 + eps, eps, 2 + eps};
top() = Surface In BoundingBox {-eps, 2 - eps, -eps, 2 + eps, 2 + eps, 2 + eps};
back() = Surface In BoundingBox {-eps, -eps, -eps, 2 + eps, 2 + eps, eps};
front() = Surface In BoundingBox {-eps, -eps, 2 - eps, 2 + eps, 2 + eps, 2 + eps};
Physical Surface("left") = {left()};
Physical Surface("right") = {right()};
Physical Surface("bottom") = {bottom()};
Physical Surface("top") = {top()};
Physical Surface("back") = {back()};
Physical Surface("front") = {front()};
Physical Surface("walls") = {left(), right(), bottom(), top(), back(), front()};
Physical Volume("ball") = {2};
Physical Volume("fluid") = {3};
MeshSize{:} = 0.35;
