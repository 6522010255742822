"""What mechanics says of multipliers at nodes (MORTar) between bodies of finite strain: tests of
tests/properties/run, which mixes this class in.
"""
import math
import re

import h5py
from mortar_laws import E, two_blocks

NU = 0.3
RUBBER = ('SOLId LINEar\n  ELAStic ISOTropic 1000 0.3', f'SOLId NEOHookean\n  ELAStic NEOHookean {E!r} {NU!r}')
ANGLE, STEPS = 15, 4  # of a pair that turns


def column_stretches(pressure):
    """Stretches across and along of a neo-Hookean column under a nominal pressure, by Newton."""
    lame, g = E*NU/((1 + NU)*(1 - 2*NU)), E/(2*(1 + NU))

    def stresses(a, c):
        volume = lame*math.log(a*a*c)
        return g*(a - 1/a) + volume/a, g*(c - 1/c) + volume/c + pressure

    a = c = 1.0
    for _ in range(40):
        p, q = stresses(a, c)
        h = 1e-7
        (pa, qa), (pc, qc) = ([(v - w)/(2*h) for v, w in zip(stresses(a + i*h, c + k*h),
                                                             stresses(a - i*h, c - k*h))]
                              for i, k in ((1, 0), (0, 1)))
        det = pa*qc - pc*qa
        a, c = a - (p*qc - q*pc)/det, c - (q*pa - p*qa)/det
    return a, c


def loaded_rubber(below, above, tilt, mu, kind, pressure, steps):
    """The two blocks of the patch test, of rubber, under a dead load in some steps."""
    text = two_blocks('MORTar over under', below, above, tilt, mu, kind).replace(*RUBBER)
    text = re.sub(r'top 0 0 .*\n', f'top 0 0 {-pressure} 1\nPROPortional 1\n  0 0\n  1 1\n', text)
    return text.replace('DT,,1\n  STEP,,1', f'DT,,1/{steps}\n  STEP,,{steps}')


def turned_pair():
    """A deck: rubber on rubber, pressed, sheared until nodes slip, and turned as a whole."""
    turns = [math.radians(ANGLE*k) for k in range(STEPS + 1)]
    blocks = [f'BLOCk {name}\n  CART {n} {n} 2  MATErial 1  TET4\n' + ''.join(
        f'  {k} {x*a} {y*b} {z}\n' for k, (x, y, z) in enumerate(
            [(i, j, z) for z in ends for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))], 1))
              for name, n, a, b, ends in (('lower', 3, 1, 1, (-1, 0)), ('upper', 4, 0.6, 0.7, (0, 0.8)))]
    return ('MFEC * * pressed pair that turns\nMATErial 1\n  SOLId NEOHookean\n  ELAStic NEOHookean 10 0.4\n'
            + ''.join(blocks) + 'SET floor\n  PLANe 3 -1\nSET lid\n  PLANe 3 0.8\n'
            'SET joint\n  PLANe 3 0\nSURFace bed FROM joint IN lower\nSURFace foot FROM joint IN upper\n'
            'CONTact\n  PAIR 1\n    MORTar foot bed\n    FRICtion ELLIptic 0.4 0.2\n'
            '    DIREction MATErial ANGLe 30 1 0 0\n    SLIP ASSOciated\n'
            f'ROTAtion\n  lid 0 0 0 0 0 1 {ANGLE} 4\n  floor 0 0 0 0 0 1 {ANGLE} 4\n'
            'DISPlacement\n  lid 0 0 -0.04 1\n  lid 0.03 0 0 2\n  lid 0 0.03 0 3\n'
            'PROPortional 1\n  0 0\n  1 1\nPROPortional 2\n  0 0\n  1 0\n'
            + ''.join(f'  {2 + k} {math.cos(t)!r}\n' for k, t in enumerate(turns))
            + 'PROPortional 3\n  0 0\n' + ''.join(f'  {2 + k} {math.sin(t)!r}\n' for k, t in enumerate(turns))
            + f'PROPortional 4\n  0 0\n  2 0\n  {2 + STEPS} {STEPS}\nOUTPut\n  REACtions floor lid\n'
            f'BATCh\n  DT,,0.5\n  STEP,,4\n  DT,,1\n  STEP,,{STEPS}\nEND\n')


class MortarRubber:
    """Tests; self.run, self.written, self.edited, self.near, self.true: from Suite."""

    def test_rubber_blocks_of_any_meshes_are_one(self):
        """A column of two blocks stretches as one of neo-Hooke's law, under small and large strain."""
        for pressure, steps in ((0.1, 1), (10, 1), (250, 4)):
            a, c = column_stretches(pressure)
            for below, above, tilt, mu, kind in (
                    ((2, 3, 2), (7, 5, 2), 0, 0.3, 'TET4'), ((4, 3, 2), (5, 4, 2), 0.3, 0.9, 'TET4'),
                    ((3, 2, 1), (4, 3, 1), 0, 0.3, 'TET10'), ((4, 3, 1), (3, 2, 1), 0.3, 0.9, 'TET10')):
                what = f'{kind} {below} under {above}, slope {tilt}, pressure {pressure}'
                text = loaded_rubber(below, above, tilt, mu, kind, pressure, steps)
                r = self.run(self.written('mortar_rubber', text))
                with h5py.File(r.base + '.vtkhdf') as file:
                    grid = file['VTKHDF']
                    x, u = grid['Points'][:], grid['PointData/displacement'][-len(grid['Points']):]
                error = max(abs(u[:, k] - ((a, a, c)[k] - 1)*x[:, k]).max() for k in range(3))
                self.near(what + ': displacements', error/(1 - c), 0, 1e-10)
                row = r.only(steps)
                self.near(what + ': force', row['F3'], pressure, 1e-9)
                self.near(what + ': no penetration', row['max_penetration'], 0, 1e-12)

    def test_pressed_rubber_turns_as_a_whole(self):
        """Forces, cone and lay turn with a pair that is turned, and no node slips on."""
        r = self.run(self.written('mortar_turn', turned_pair()))
        still = r.only(4)
        for k in range(STEPS + 1):
            row, floor = r.only(4 + k), r.rea[4 + k]['floor']
            c, s = math.cos(math.radians(ANGLE*k)), math.sin(math.radians(ANGLE*k))
            back = (c*row['F1'] + s*row['F2'], c*row['F2'] - s*row['F1'], row['F3'])
            for axis in range(3):
                self.near(f'turn {k}: force {axis + 1}', (back[axis] - still[f'F{axis + 1}'])/still['F3'],
                          0, 1e-6)
                self.near(f'turn {k}: balance {axis + 1}', (row[f'F{axis + 1}'] - floor[axis])/still['F3'],
                          0, 1e-10)
        self.true('some nodes slip, some stick', 0 < still['slip'] < still['active'])

    def test_rounds_are_newton_steps_of_the_bulk(self):
        """What is left falls by the square from round to round where nothing else changes."""
        text = loaded_rubber((4, 3, 2), (5, 4, 2), 0.3, 0.9, 'TET4', 40, 1)
        log = self.run(self.written('mortar_order', text)).text('.log').decode()
        left = [float(v) for v in re.findall(r'Residual norm = +(\S+)', log)]
        self.true(f'left {left}', len(left) > 3 and any(
            math.log(c/b)/math.log(b/a) > 1.7 for a, b, c in zip(left, left[1:], left[2:])
            if c < b < a and b < 1e-2*a))
