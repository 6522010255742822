#!/usr/bin/env python3
"""Makes the mesh files of tests/meshes and inputs/sphere.msh with gmsh (pip install gmsh).

    tests/meshes/make_meshes.py FOLDER

sphere    radius 1 about the origin, cut at x3 = 0.4: surfaces skin, cap; region ball; sets
          rim (curve) and pole (point)
cylinder  radius 0.5, length 1 along x1: surfaces side, left, right; region shaft
plate     4 x 2 x 0.4, two regions that hang together: surfaces top, bottom; regions near, far
ten       the sphere in tetrahedra of ten nodes, whose facets follow it
"""
import sys

import gmsh


def start(name, size):
    """An empty model with elements of one size."""
    gmsh.clear()
    gmsh.model.add(name)
    gmsh.option.setNumber('General.Terminal', 0)
    gmsh.option.setNumber('Mesh.MeshSizeMin', size)
    gmsh.option.setNumber('Mesh.MeshSizeMax', size)
    gmsh.option.setNumber('Mesh.RandomSeed', 1)


def group(dimension, name, chosen):
    """A physical group of the entities whose centre is chosen."""
    tags = []
    for _, tag in gmsh.model.getEntities(dimension):
        if chosen(gmsh.model.occ.getCenterOfMass(dimension, tag)):
            tags.append(tag)
    gmsh.model.addPhysicalGroup(dimension, tags, name=name)


def write(path, version, binary=False):
    """Writes the mesh at hand."""
    gmsh.option.setNumber('Mesh.MshFileVersion', version)
    gmsh.option.setNumber('Mesh.Binary', int(binary))
    gmsh.write(path)


def sphere(size):
    """A ball without its upper cap."""
    start('sphere', size)
    ball = gmsh.model.occ.addSphere(0, 0, 0, 1)
    box = gmsh.model.occ.addBox(-2, -2, 0.4, 4, 4, 4)
    gmsh.model.occ.cut([(3, ball)], [(3, box)])
    gmsh.model.occ.synchronize()
    group(3, 'ball', lambda c: True)
    group(2, 'cap', lambda c: c[2] > 0.39)
    group(2, 'skin', lambda c: c[2] < 0.39)
    rim = [t for _, t in gmsh.model.getEntities(1)
           if gmsh.model.getBoundingBox(1, t)[2] > 0.39]
    gmsh.model.addPhysicalGroup(1, rim, name='rim')
    pole = [t for d, t in gmsh.model.getEntities(0)
            if gmsh.model.getValue(0, t, [])[2] < -0.9]
    gmsh.model.addPhysicalGroup(0, pole, name='pole')
    gmsh.model.mesh.generate(3)


def refined_sphere():
    """The same with small triangles about the pole x3 = -1: for inputs/sphere_on_plate.inp."""
    fields = gmsh.model.mesh.field
    ball = fields.add('Ball')
    for option, value in (('Radius', 0.35), ('ZCenter', -1), ('Thickness', 1), ('VIn', 0.1),
                          ('VOut', 0.5)):
        fields.setNumber(ball, option, value)
    fields.setAsBackgroundMesh(ball)
    gmsh.option.setNumber('Mesh.MeshSizeMin', 0.1)
    gmsh.option.setNumber('Mesh.MeshSizeMax', 0.5)
    gmsh.option.setNumber('Mesh.MeshSizeExtendFromBoundary', 0)
    gmsh.model.mesh.clear()
    gmsh.model.mesh.generate(3)


def cylinder(size):
    """A cylinder along x1."""
    start('cylinder', size)
    gmsh.model.occ.addCylinder(0, 0, 0, 1, 0, 0, 0.5)
    gmsh.model.occ.synchronize()
    group(3, 'shaft', lambda c: True)
    group(2, 'left', lambda c: c[0] < 0.01)
    group(2, 'right', lambda c: c[0] > 0.99)
    group(2, 'side', lambda c: 0.01 < c[0] < 0.99)
    gmsh.model.mesh.generate(3)


def plate(size):
    """Two boxes with a common face."""
    start('plate', size)
    one = gmsh.model.occ.addBox(-2, -1, -0.4, 2, 2, 0.4)
    two = gmsh.model.occ.addBox(0, -1, -0.4, 2, 2, 0.4)
    gmsh.model.occ.fragment([(3, one)], [(3, two)])
    gmsh.model.occ.synchronize()
    group(3, 'near', lambda c: c[0] < 0)
    group(3, 'far', lambda c: c[0] > 0)
    group(2, 'top', lambda c: c[2] > -0.01)
    group(2, 'bottom', lambda c: c[2] < -0.39)
    gmsh.model.mesh.generate(3)


def ten_nodes(folder):
    """The sphere in tetrahedra of ten nodes, in all formats that mfec reads."""
    gmsh.option.setNumber('Mesh.MeshSizeExtendFromBoundary', 1)
    sphere(0.7)
    gmsh.model.mesh.setOrder(2)
    for version, name in ((4.1, '41'), (2.2, '22')):
        write(f'{folder}/ten{name}.msh', version)
        write(f'{folder}/ten{name}_binary.msh', version, True)
    gmsh.option.setNumber('Mesh.SaveGroupsOfElements', 1)
    gmsh.option.setNumber('Mesh.SaveGroupsOfNodes', 0)
    gmsh.write(f'{folder}/ten.inp')


def main():
    """All files."""
    folder = sys.argv[1] if len(sys.argv) > 1 else '.'
    gmsh.initialize()
    sphere(0.35)
    write(f'{folder}/sphere41.msh', 4.1)
    write(f'{folder}/sphere22.msh', 2.2)
    write(f'{folder}/sphere41_binary.msh', 4.1, True)
    write(f'{folder}/sphere22_binary.msh', 2.2, True)
    refined_sphere()
    write(f'{folder}/sphere.msh', 4.1)
    cylinder(0.3)
    write(f'{folder}/cylinder.msh', 4.1)
    gmsh.option.setNumber('Mesh.SaveGroupsOfElements', 1)
    gmsh.option.setNumber('Mesh.SaveGroupsOfNodes', 0)
    gmsh.write(f'{folder}/cylinder.inp')
    plate(0.45)
    write(f'{folder}/plate.msh', 4.1)
    ten_nodes(folder)
    gmsh.finalize()


if __name__ == '__main__':
    main()
