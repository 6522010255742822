// A quarter of an O-ring: diameter of the ring 20, of its section 4. See seal.inp.
//   gmsh -3 seal.geo -order 2 -format msh22 -o seal.msh
SetFactory("OpenCASCADE");
Torus(1) = {0, 0, 0, 10, 2, Pi/2};
Mesh.MeshSizeMax = 1.15;
Mesh.MeshSizeMin = 1.15;
Mesh.HighOrderOptimize = 2;
Physical Volume("ring") = {1};
Physical Surface("skin") = {1};
