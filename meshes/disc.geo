// The disc of radius 1 about (0, 0). The inner half is a region of its own, and belongs to two groups.
SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 1};
Disk(2) = {0, 0, 0, 0.5};
BooleanFragments{ Surface{1}; Delete; }{ Surface{2}; Delete; }
Physical Surface("fluid") = {2, 3};
Physical Surface("core") = {2};
Physical Curve("wall") = CombinedBoundary{ Surface{:}; };
MeshSize{:} = 0.1;
