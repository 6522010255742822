#!/usr/bin/env python3
"""Writes the input files of this case: an assembly of two parts and three instances, as Abaqus/CAE
lays it out, with nodes and elements of one part in files of their own."""


def cube(n, size):
    """Nodes and tetrahedra of a cube of n cells an edge."""
    k = n + 1
    nodes = [(size*a/n, size*b/n, size*c/n) for c in range(k) for b in range(k) for a in range(k)]

    def number(a, b, c):
        return 1 + a + k*(b + k*c)

    cells = []
    for c in range(n):
        for b in range(n):
            for a in range(n):
                v = [number(a + i, b + j, c + l) for i, j, l in (
                    (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                    (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
                cells += [[v[i - 1] for i in t] for t in (
                    (1, 2, 3, 7), (1, 3, 4, 7), (1, 4, 8, 7), (1, 8, 5, 7), (1, 5, 6, 7), (1, 6, 2, 7))]
    return nodes, cells


def lines(rows):
    return ''.join(', '.join(str(v) for v in row) + '\n' for row in rows)


def main():
    nodes, cells = cube(2, 1.0)
    with open('block_nodes.inc', 'w') as f:
        f.write(lines([i, *x] for i, x in enumerate(nodes, 1)))
    with open('block.inc', 'w') as f:
        f.write('*Node, input=block_nodes.inc\n*Element, type=C3D4\n')
        f.write(lines([i, *c] for i, c in enumerate(cells, 1)))
        f.write(f'*Nset, nset=All, generate\n1, {len(nodes)}, 1\n')
        f.write(f'*Elset, elset=All, generate\n1, {len(cells)}, 1\n')
        f.write('*Nset, nset=Low, generate\n1, 9, 1\n*Nset, nset=High, generate\n19, 27, 1\n')
        f.write('** Section\n*Solid Section, elset=All, material=Steel\n,\n')
    nodes, cells = cube(2, 2.0)
    with open('assembly.abq', 'w') as f:
        f.write('*Heading\nTwo blocks on a base\n**\n** PARTS\n*Part, name=Block\n')
        f.write('*Include, input=block.inc\n*End Part\n**\n*Part, name=Base\n*Node\n')
        f.write(lines([i, *x] for i, x in enumerate(nodes, 1)))
        f.write('*Element, type=C3D4, elset=Body\n')
        f.write(lines([10*i, *c] for i, c in enumerate(cells, 1)))
        f.write('*Solid Section, elset=Body, material=Rubber\n,\n*End Part\n**\n** ASSEMBLY\n')
        f.write('*Assembly, name=Assembly\n*Instance, name=Base-1, part=Base\n*End Instance\n')
        f.write('*Instance, name=Block-1, part=Block\n0., 0.5, 2.\n*End Instance\n')
        # turned by 90 degrees about its vertical edge: it lies where x is 1 to 2
        f.write('*Instance, name=Block-2, part=Block\n2., 0.5, 2.\n')
        f.write('2., 0.5, 2., 2., 0.5, 3., 90.\n*End Instance\n')
        f.write('*Nset, nset=Under, instance=Base-1, generate\n1, 9, 1\n')
        f.write('*Nset, nset=Pressed, instance=Block-1\nHigh,\n')
        f.write('*Nset, nset=Pressed, instance=Block-2\n19, 20, 21, 22, 23, 24, 25, 26, 27\n')
        f.write('*Elset, elset=_Top_S2, internal, instance=Base-1\n')
        f.write(''.join(f'{10*i},\n' for i, c in enumerate(cells, 1)
                        if {nodes[c[0] - 1][2], nodes[c[1] - 1][2], nodes[c[3] - 1][2]} == {2.0}))
        f.write('*Elset, elset=_Top_S3, internal, instance=Base-1\n')
        f.write(''.join(f'{10*i},\n' for i, c in enumerate(cells, 1)
                        if {nodes[c[1] - 1][2], nodes[c[2] - 1][2], nodes[c[3] - 1][2]} == {2.0}))
        f.write('*Elset, elset=_Top_S4, internal, instance=Base-1\n')
        f.write(''.join(f'{10*i},\n' for i, c in enumerate(cells, 1)
                        if {nodes[c[0] - 1][2], nodes[c[2] - 1][2], nodes[c[3] - 1][2]} == {2.0}))
        f.write('*Surface, type=ELEMENT, name=Top\n_Top_S2, S2\n_Top_S3, S3\n_Top_S4, S4\n')
        f.write('*Surface, type=NODE, name=Feet\nBlock-1.Low\nBlock-2.Low\n')
        f.write('*End Assembly\n*Material, name=Steel\n*Elastic\n210000., 0.3\n')


main()
