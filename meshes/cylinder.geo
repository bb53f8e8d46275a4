// The channel of channel.geo, fine enough for the benchmark of Schaefer and Turek (1996): about 5000 triangles.
Include "channel.geo";
MeshSize{:} = 0.026;
MeshSize{PointsOf{Curve{cylinder()};}} = 0.0036;
