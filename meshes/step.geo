// A backward-facing step of expansion ratio 2, step and inlet 1 high: the inlet channel is 4 long, the wide one 30.
// About 5000 triangles, finest at the edge of the step.
before = 4;  after = 30;
Point(1) = {-before, 1, 0};
Point(2) = {0, 1, 0};
Point(3) = {0, 0, 0};
Point(4) = {after, 0, 0};
Point(5) = {after, 2, 0};
Point(6) = {-before, 2, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 1};
Curve Loop(1) = {1:6};
Plane Surface(1) = {1};
Physical Curve("inlet") = {6};
Physical Curve("outlet") = {4};
Physical Curve("walls") = {1, 2, 3, 5};
Physical Surface("fluid") = {1};

Field[1] = Distance;
Field[1].NodesList = {2};
Field[2] = MathEval;
Field[2].F = "0.01 + 0.1*F1";
Field[3] = MathEval;
Field[3].F = "0.13 + 0.03*Fabs(x - 10)*(1 + (x - 10)/Fabs(x - 10 + 1e-9))/2";
Field[4] = Min;
Field[4].FieldsList = {2, 3};
Background Field = 4;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
