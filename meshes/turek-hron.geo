// The channel of Turek and Hron (2006) with a cylinder and a rod behind it, both rigid (CFD1, CFD2, CFD3): 2.5 x 0.41, the cylinder of
// diameter 0.1 about (0.2, 0.2), the rod 0.02 thick and up to x = 0.6. About 7000 triangles, finest at the two corners of its end.
SetFactory("OpenCASCADE");
length = 2.5;  height = 0.41;
Rectangle(1) = {0, 0, 0, length, height};
Disk(2) = {0.2, 0.2, 0, 0.05};
Rectangle(3) = {0.2, 0.19, 0, 0.4, 0.02};
BooleanUnion(4) = { Surface{2}; Delete; }{ Surface{3}; Delete; };
BooleanDifference(5) = { Surface{1}; Delete; }{ Surface{4}; Delete; };
eps = 1e-6;
inlet() = Curve In BoundingBox {-eps, -eps, -eps, eps, height + eps, eps};
outlet() = Curve In BoundingBox {length - eps, -eps, -eps, length + eps, height + eps, eps};
bottom() = Curve In BoundingBox {-eps, -eps, -eps, length + eps, eps, eps};
top() = Curve In BoundingBox {-eps, height - eps, -eps, length + eps, height + eps, eps};
body() = Curve In BoundingBox {0.1, 0.1, -eps, 0.7, 0.3, eps};
tip() = Point In BoundingBox {0.6 - eps, 0.1, -eps, 0.6 + eps, 0.3, eps};
Physical Curve("inlet") = {inlet()};
Physical Curve("outlet") = {outlet()};
Physical Curve("walls") = {bottom(), top()};
Physical Curve("body") = {body()};
Physical Surface("fluid") = {5};

Field[1] = Distance;
Field[1].CurvesList = {body()};
Field[1].NNodesByEdge = 400;
Field[2] = Distance;
Field[2].NodesList = {tip()};
Field[3] = MathEval;
Field[3].F = "0.0054 + 0.12*F1";
Field[4] = MathEval;
Field[4].F = "0.0011 + 0.13*F2";
Field[5] = MathEval;
Field[5].F = "0.023 + 0.014*Fabs(x - 0.9)*(1 + (x - 0.9)/Fabs(x - 0.9 + 1e-9))/2";
Field[6] = Min;
Field[6].FieldsList = {3, 4, 5};
Background Field = 6;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
