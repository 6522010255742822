// A bolt in a bored housing: gmsh -3 bolt.geo -format msh22 -o bolt.msh
SetFactory("OpenCASCADE");
Mesh.MeshSizeMax = 5;
Mesh.MeshSizeFromCurvature = 36;              // elements around a full circle

Box(1) = {0, 0, 0, 40, 30, 8};                // the housing
Cylinder(2) = {25, 15, 0, 0, 0, 8, 6};        // its bore: a point of the axis, the axis, the radius
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Cylinder(4) = {25, 15, -1, 0, 0, 10, 5.99};   // the bolt, longer than the bore

Physical Volume("housing") = {3};
Physical Volume("bolt") = {4};
e = 1e-3;                                     // surfaces that lie in a box as a whole
Physical Surface("foot") = Surface In BoundingBox{-e, -e, -e, e, 30+e, 8+e};
Physical Surface("bore") = Surface In BoundingBox{19-e, 9-e, -e, 31+e, 21+e, 8+e};
shank() = Surface In BoundingBox{19.01-e, 9.01-e, -1-e, 30.99+e, 20.99+e, 9+e};
shank() -= Surface In BoundingBox{19.01-e, 9.01-e, -1-e, 30.99+e, 20.99+e, -1+e};
shank() -= Surface In BoundingBox{19.01-e, 9.01-e, 9-e, 30.99+e, 20.99+e, 9+e};
Physical Surface("shank") = shank();
