// The channel of channel.geo for the benchmarks DFG 2D-1, 2D-2 and 2D-3 (Schaefer and Turek 1996): about 7000 triangles, edges of
// 0.0031 at the cylinder, 100 around it, 0.012 beside it, 0.02 in the wake and 0.035 at the outlet.
Include "channel.geo";
Field[1] = Distance;
Field[1].CurvesList = {cylinder()};
Field[1].NNodesByEdge = 400;
// Short edges for as far as the boundary layer goes, then edges that grow by a tenth of the distance.
Field[2] = MathEval;
Field[2].F = "0.0031 + 0.1*F1";
Field[3] = MathEval;
Field[3].F = "0.0185 + 0.012*Fabs(x - 0.7)*(1 + (x - 0.7)/Fabs(x - 0.7 + 1e-9))/2";
Field[4] = Min;
Field[4].FieldsList = {2, 3};
Background Field = 4;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
