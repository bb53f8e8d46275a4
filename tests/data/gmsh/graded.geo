// A channel, fine at the left and coarse at the right.
Point(1) = {0, 0, 0, 0.055};
Point(2) = {0.8, 0, 0, 0.055};
Point(3) = {2.5, 0, 0, 0.4};
Point(4) = {2.5, 1, 0, 0.4};
Point(5) = {0.8, 1, 0, 0.055};
Point(6) = {0, 1, 0, 0.055};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Curve Loop(1) = {1, 2, 3, 4, 5, 6}; Plane Surface(1) = {1};
Physical Curve("left") = {6}; Physical Curve("right") = {3};
Physical Surface("fluid") = {1};
