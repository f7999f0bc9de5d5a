// A mesh of your own for the lab-scale roll: gmsh -2 meshes/own_roll.geo -o own_roll.msh
// Needed: mid-surfaces in metres, axis z, base at z = 0, 9-node quads, equal divisions on every shell,
// and the physical groups NAME, NAME_base, NAME_tip for NAME = mandrel, layer_01, layer_02, ...
// A node at theta = 0 and divisions that mirror about the x-z plane let the program use half the roll.
length = 0.300;
radii[] = {0.040 - 0.75e-3, 0.040 + 0.625e-3}; // mandrel 1.5 mm, one layer 1.25 mm
quarter = 3;                                    // elements per quarter of the circumference
axial = 4;
centre = newp; Point(centre) = {0, 0, 0};
For k In {0 : #radii[] - 1}
  name = StrChoice(k == 0, "mandrel", Sprintf("layer_%02g", k));
  p = newp;
  Point(p) = {radii[k], 0, 0}; Point(p + 1) = {0, radii[k], 0};
  Point(p + 2) = {-radii[k], 0, 0}; Point(p + 3) = {0, -radii[k], 0};
  base[] = {}; tip[] = {}; wall[] = {};
  For i In {0 : 3}
    arc = newl;
    Circle(arc) = {p + i, centre, p + (i + 1) % 4};
    Transfinite Curve {arc} = quarter + 1;
    swept[] = Extrude {0, 0, length} { Curve{arc}; Layers{axial}; Recombine; };
    base[] += {arc}; tip[] += {swept[0]}; wall[] += {swept[1]};
  EndFor
  Physical Surface(Str(name)) = {wall[]};
  Physical Curve(StrCat(name, "_base")) = {base[]};
  Physical Curve(StrCat(name, "_tip")) = {tip[]};
EndFor
Mesh.ElementOrder = 2;
