// A ball of radius 1, or with -setnumber cube 1 the cube [-1, 1]^3, fine about the sphere of radius 0.5: edges h up to 0.33 from it.
// gmsh -3 -setnumber h 0.07 about-sphere.geo -o ball.msh
SetFactory("OpenCASCADE");
If (!Exists(h))
  h = 0.07;
EndIf
If (!Exists(cube))
  cube = 0;
EndIf
If (cube)
  Box(1) = {-1, -1, -1, 2, 2, 2};
  Physical Surface("walls") = {1:6};
Else
  Sphere(1) = {0, 0, 0, 1};
  Physical Surface("walls") = {1};
EndIf
Physical Volume("fluid") = {1};
// h + 0.35 max(| |x| - 0.5 | - 0.33, 0)
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.175*(abs(abs(sqrt(x*x+y*y+z*z)-0.5)-0.33)+abs(sqrt(x*x+y*y+z*z)-0.5)-0.33)", h);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm3D = 10;
Mesh.MshFileVersion = 4.1;
Mesh.Binary = 1;
