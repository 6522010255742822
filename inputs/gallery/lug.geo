// A lug with its pin, for inputs/gallery/lug.inp:  gmsh -3 lug.geo -format msh22 -o lug.msh
SetFactory("OpenCASCADE");
Mesh.MeshSizeMax = 0.3;
Mesh.MeshSizeFromCurvature = 20;      // elements around a full circle

Box(1) = {0, -0.5, 0, 1.6, 1, 0.25};  // the bar
Cylinder(2) = {1.6, 0, 0, 0, 0, 0.25, 0.5};
Cylinder(3) = {1.6, 0, 0, 0, 0, 0.25, 0.25};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
BooleanDifference(5) = { Volume{4}; Delete; }{ Volume{3}; Delete; };
Cylinder(6) = {1.6, 0, -0.1, 0, 0, 0.45, 0.248};

Physical Volume("lug") = {5};
Physical Volume("pin") = {6};
e = 1e-3;
Physical Surface("hole") = Surface In BoundingBox{1.35-e, -0.25-e, -e, 1.85+e, 0.25+e, 0.25+e};
Physical Surface("shank") = Surface In BoundingBox{1.352-e, -0.248-e, -0.1-e, 1.848+e, 0.248+e, 0.35+e};
Physical Surface("root") = Surface In BoundingBox{-e, -0.5-e, -e, e, 0.5+e, 0.25+e};
