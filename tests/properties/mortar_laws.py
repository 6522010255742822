"""What mechanics says of multipliers at nodes (MORTar): tests of tests/properties/run, which mixes
this class in.
"""
import os

import h5py

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
E, PRESSURE = 1000.0, 10.0


def block(name, cells, low, high, tilt, kind):
    """A BLOCk whose joint at z = 1 leans along x."""
    lines = [f'BLOCk {name}', '  CART {} {} {}  MATErial 1  {}'.format(*cells, kind)]
    for k, bits in enumerate(CORNERS, 1):
        x, y, z = ((low, high)[b][axis] for axis, b in enumerate(bits))
        if z == 1:
            z += tilt*(x - 0.5)
        lines.append(f'  {k}  {x} {y} {z!r}')
    return '\n'.join(lines) + '\n'


def two_blocks(form, below, above, tilt, mu, kind):
    """A column of two blocks with frictionless sides on two planes, pressed from above."""
    boxes = []  # of the nodes of the joint, which leans: a box for each column of nodes
    for x in sorted({a/(2*m) for m in (below[0], above[0]) for a in range(2*m + 1)}):
        z = 1 + tilt*(x - 0.5)
        boxes.append(f'  BOX {x - 1e-6!r} {x + 1e-6!r} -1 2 {z - 1e-5!r} {z + 1e-5!r}\n')
    return ('MFEC * * two blocks\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic 1000 0.3\n'
            + block('low', below, (0, 0, 0), (1, 1, 1), tilt, kind)
            + block('high', above, (0, 0, 1), (1, 1, 2), tilt, kind)
            + 'SET floor\n  PLANe 3 0\nSET lid\n  PLANe 3 2\nSET x0\n  PLANe 1 0\nSET y0\n  PLANe 2 0\n'
            + 'SURFace under FROM joint IN low\nSURFace over FROM joint IN high\nSURFace top FROM lid\n'
            + 'SET joint\n' + '  OR\n'.join(boxes)
            + f'CONTact\n  PAIR 1\n    {form}\n    FRICtion COULomb {mu}\n'
            + 'BOUNdary\n  floor 0 0 1\n  x0 1 0 0\n  y0 0 1 0\n'
            + f'TRACtion\n  top 0 0 {-PRESSURE}\nOUTPut\n  REACtions floor\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')


class MortarLaws:
    """Tests of MORTar; self.run, self.edited, self.near, self.true, self.agree: from Suite."""

    def written(self, name, text):
        path = os.path.join(self.folder, name + '.inp')
        with open(path, 'w', encoding='ascii') as stream:
            stream.write(text)
        return path

    def test_blocks_of_any_meshes_are_one(self):
        """An even pressure goes through a joint whose meshes do not fit, flat and leaning."""
        for below, above, tilt, mu, kind in (
                ((2, 3, 2), (7, 5, 2), 0, 0.3, 'TET4'), ((7, 5, 1), (2, 3, 2), 0, 0.0, 'TET4'),
                ((4, 3, 2), (5, 4, 2), 0.3, 0.9, 'TET4'), ((3, 2, 2), (2, 2, 2), 0.3, 0.9, 'TET4'),
                ((3, 2, 1), (4, 3, 1), 0, 0.3, 'TET10'), ((4, 3, 1), (3, 2, 1), 0.3, 0.9, 'TET10')):
            what = f'{kind} {below} under {above}, slope {tilt}'
            text = two_blocks('MORTar over under', below, above, tilt, mu, kind)
            r = self.run(self.written('mortar_patch', text))
            with h5py.File(r.base + '.vtkhdf') as file:
                grid = file['VTKHDF']
                x, u = grid['Points'][:], grid['PointData/displacement'][-len(grid['Points']):]
            error = max(abs(u[:, k] - PRESSURE/E*x[:, k]*(0.3, 0.3, -1)[k]).max() for k in range(3))
            self.near(what + ': displacements', error*E/PRESSURE, 0, 1e-10)
            c = r.only(1)
            self.near(what + ': force', c['F3'], PRESSURE, 1e-9)
            if tilt == 0:  # nodes on a symmetry plane hand the part along its normal to their supports
                self.near(what + ': friction', c['Ft'], 0, 1e-9)
            self.near(what + ': no penetration', c['max_penetration'], 0, 1e-12)

    def test_joint_slides_by_the_law(self):
        """Forces of both sides cancel, multipliers stay in their cone, steady slip is on it."""
        r = self.input('mortar_blocks')
        for step in r.con:
            c, floor = r.only(step), r.rea[step]['floor']
            for k in range(3):
                self.near(f'row {step}: force {k + 1}', c[f'F{k + 1}'], floor[k], 1e-11)
            self.near(f'row {step}: no penetration', c['max_penetration'], 0, 1e-14)
            self.true(f'row {step}: within the cone', c['max_criterion'] < 1e-12*c['Fn'])
            self.true(f'row {step}: nodes of the slave at most', c['active'] <= 30)
        self.true('all slip at the end', r.only(6)['slip'] == r.only(6)['active'] > 0)
        self.true('no cut', b' 0 cuts' in r.text('.log'))

    def test_mortar_is_the_limit_of_stiff_penalties(self):
        """GTOS with ever stiffer penalties comes to the forces of MORTar, to a percent of them."""
        mortar = self.input('mortar_blocks')
        gaps = []
        for factor in (10, 1000):
            deck = self.edited('mortar_blocks', (r'MORTar    foot bed',
                                                 f'GTOS foot bed SEGMent\n    PENAlty AUTO {factor}'))
            r = self.run(deck, out=f'factor{factor}')
            gaps.append(max(abs(r.only(k)['F3'] - mortar.only(k)['F3'])/mortar.only(k)['F3'] for k in r.con))
        self.true(f'distances {gaps}', gaps[1] < 0.3*gaps[0] and gaps[1] < 0.01)

    def test_steady_sliding_does_not_pay_twice(self):
        """Compliance and factors serve an increment, and few rounds settle the weights."""
        r = self.input('mortar_blocks')
        costs, steps = r.costs(), len(r.con)
        self.true(f'compliances: {costs}', steps <= costs['compliances of multipliers'] <= 2*steps)
        self.true(f'factors: {costs}', costs['dense factorisation'] <= 6*steps)
        self.true(f'rounds: {costs}', costs['rounds of multipliers'] <= 8*steps)
        self.true(f'weighed: {costs}', costs['multipliers weighed'] <= 30*(costs['rounds of multipliers'] + 4*steps))

    def test_a_stack_is_held_by_friction(self):
        """Bodies that contact alone holds find their friction from nothing."""
        deck = self.edited('gallery/stack_on_slope', (r'GTOS    ', 'MORTar  '), (r'    PENAlty  AUTO\n', ''))
        r = self.run(deck)
        self.true('no cut', b' 0 cuts' in r.text('.log'))
        for name, weight in (('first_on_slope', 3), ('second_on_first', 2), ('third_on_second', 1)):
            self.near(name, r.con[4][name]['F3'], weight, 1e-9)
