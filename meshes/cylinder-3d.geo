// The channel of the benchmark DFG 3D-1Z (Schaefer and Turek 1996): 2.5 x 0.41 x 0.41 with a cylinder of diameter 0.1 from wall to wall, along z
// through (0.5, 0.2). A mesh of the plane, drawn out along z in layers that are thin at the two walls. `-setnumber fine 1.5` divides all edges by 1.5.
SetFactory("OpenCASCADE");
DefineConstant[ fine = {1, Name "fine"} ];
height = 0.41;  length = 2.5;
Rectangle(1) = {0, 0, 0, length, height};
Disk(2) = {0.5, 0.2, 0, 0.05};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
// Layers as wide as those of a cosine: n at the fractions (1 - cos(pi k/n))/2, mixed half and half with equal ones.
n = Round(6*fine);
For k In {1 : n}
  ones[k - 1] = 1;
  at[k - 1] = (1 - Cos(Pi*k/n))/4 + k/n/2;
EndFor
Extrude {0, 0, height} { Surface{3}; Layers{ ones[], at[] }; }
eps = 1e-6;
inlet() = Surface In BoundingBox {-eps, -eps, -eps, eps, height + eps, height + eps};
outlet() = Surface In BoundingBox {length - eps, -eps, -eps, length + eps, height + eps, height + eps};
cylinder() = Surface In BoundingBox {0.4, 0.1, -eps, 0.6, 0.3, height + eps};
all() = Boundary{ Volume{1}; };
rest() = all();
rest() -= inlet();
rest() -= outlet();
rest() -= cylinder();
Physical Surface("inlet") = {inlet()};
Physical Surface("outlet") = {outlet()};
Physical Surface("cylinder") = {cylinder()};
Physical Surface("walls") = {rest()};
Physical Volume("fluid") = {1};
round() = Curve In BoundingBox {0.4, 0.1, -eps, 0.6, 0.3, eps};
Field[1] = Distance;
Field[1].CurvesList = {round()};
Field[1].NNodesByEdge = 200;
Field[2] = MathEval;
Field[2].F = Sprintf("(0.0115 + 0.35*F1)/%g", fine);
Field[3] = MathEval;
Field[3].F = Sprintf("(0.09 + 0.12*Fabs(x - 0.6))/%g", fine);
Field[4] = Min;
Field[4].FieldsList = {2, 3};
Background Field = 4;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
