"""Stresses at nodes against fields that are known: tests of tests/properties/run, which mixes this
class in."""
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.join(HERE, '..', 'verification'))
import meshing  # noqa: E402
import quadratic_studies as quadratic  # noqa: E402

CENTER = (-0.5, -0.6, -0.45)
YOUNG, NU, SCALE = 1000.0, 0.3, 1e-3


def source_stress(x):
    """Stress of u = SCALE r/|r|^3 about CENTER: no divergence, H = I/|r|^3 - 3 r r/|r|^5."""
    r = [a - b for a, b in zip(x, CENTER)]
    size = math.sqrt(sum(a*a for a in r))
    shear = YOUNG/(2*(1 + NU))
    return [2*shear*SCALE*((i == j)/size**3 - 3*r[i]*r[j]/size**5)
            for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))]


def norm(s):
    """Norm of a tensor of six components."""
    return math.sqrt(sum(v*v for v in s[:3]) + 2*sum(v*v for v in s[3:]))


class StressLaws:
    """Tests of stresses at nodes; self.run, self.true come from Suite."""

    def source_error(self, nodes, n):
        """Error of the stress at the nodes of the surface of a cube beside a source, over its size,
        both in the mean of squares; the same of the nodes inside."""
        mesh = meshing.Mesh()
        mesh.box((n, n, n), lambda *cell: tuple(
            c/n + (0.15/n*math.sin(7*cell[0] + 5*cell[1] + 3*cell[2] + k) if 0 < c < n else 0.0)
            for k, c in enumerate(cell)))
        if nodes == 10:
            mesh = quadratic.ten_nodes(mesh)
        outside = set(mesh.where(lambda *x: any(v in (0.0, 1.0) for v in x)))
        field = quadratic.source_at(CENTER)
        given = {m: tuple(SCALE*v for v in field(mesh.nodes[m - 1])) for m in outside}
        path = os.path.join(self.folder, f'source_{nodes}_{n}.inp')
        with open(path, 'w', encoding='ascii') as stream:
            stream.write('MFEC * * A source outside of a cube\n\n' + meshing.solid(1, YOUNG, NU) +
                         quadratic.records(mesh) +
                         meshing.vectors('BOUNdary', {m: (1, 1, 1) for m in outside}) +
                         meshing.vectors('DISPlacement', given) + 'OUTPut\n  FIELds displacement\n\n'
                         'END\nBATCh\n  DT,,1\n  STEP,,1\n  STRE,NODE\nEND\nSTOP\n')
        log = self.run(path, out=f'source_{nodes}_{n}').text('.log').decode()
        sums = {True: [0.0, 0.0], False: [0.0, 0.0]}
        for line in log[log.index('stresses at time'):].splitlines()[1:]:
            items = line.split()
            if len(items) != 8 or not items[0].isdigit():
                break
            exact = source_stress(mesh.nodes[int(items[0]) - 1])
            found = [float(v) for v in items[1:7]]
            both = sums[int(items[0]) in outside]
            both[0] += norm([a - b for a, b in zip(found, exact)])**2
            both[1] += norm(exact)**2
        return [math.sqrt(a/b) for a, b in (sums[True], sums[False])]

    def test_nodal_stress_converges(self):
        # before: means of elements, .34 .17 (four nodes), .49 .27 (ten) on the surface: order 1, 0.9
        for nodes, sizes, order, most in ((4, (4, 8), 1.25, 0.12), (10, (2, 4), 1.9, 0.045)):
            coarse, fine = (self.source_error(nodes, n) for n in sizes)
            for k, where in enumerate(('surface', 'inside')):
                reached = math.log(coarse[k]/fine[k])/math.log(sizes[1]/sizes[0])
                self.true(f'{nodes} nodes, {where}: errors {coarse[k]:.4f} {fine[k]:.4f}, order {reached:.2f}',
                          reached > order and fine[k] < most)
