"""What mechanics says of rigid bodies with a point and of press fits: tests of tests/properties/run,
which mixes this class in.
"""
import math
import os
import shutil

GALLERY = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'inputs', 'gallery')
RIG = 'U1 U2 U3 ROT1 ROT2 ROT3 F1 F2 F3 M1 M2 M3'.split()


def rigid_rows(result):
    """Rows of x.rig: table[step][body] = {column: value}."""
    table = {}
    for line in result.text('.rig').decode().splitlines():
        if line.startswith('#'):
            continue
        words = line.split()
        values = dict(zip(RIG, map(float, words[3:])))
        table.setdefault(int(words[0]), {})[words[2]] = values
    return table


class RigidLaws:
    """Tests of rigid bodies; self.run, self.edited, self.near, self.true, self.agree: from Suite."""

    def test_pin_on_a_disc_that_turns_with_its_lay(self):
        r = self.input('gallery/ground_disc')
        table = rigid_rows(r)
        self.true(f'{len(table)} rows', len(table) == 37)
        for step in range(2, 38):
            a = math.radians(10*(step - 1.5))
            pin = table[step]['pin']
            self.near(f'T/N at {math.degrees(a):.0f} degrees', math.hypot(pin['F1'], pin['F2'])/0.002
                      * math.hypot(math.sin(a)/0.3, math.cos(a)/0.1), 1, 0.01)
            self.near(f'the plate carries the load in step {step}', table[step]['plate']['F3'], 0.002, 1e-10)
        self.near('one turn', table[37]['plate']['ROT3'], 2*math.pi, 1e-12)

    def test_cylinder_rolls(self):  # strains are 1 %, and so is the creep of a soft floor at most
        table = rigid_rows(self.input('gallery/rolling_cylinder'))
        for step in range(3, 27):
            wheel = table[step]['roller']
            self.near(f'angle over way in step {step}', wheel['ROT2'] - wheel['U1'], 0, 0.002)
            self.true(f'it rolls in step {step}', abs(wheel['F1']) < 0.01*0.5*4)
            self.near('F3 is that of no constraint', wheel['F3'], 0, 0)

    def test_loads_on_a_point_are_carried(self):
        for mu in ('0', '0.3', '0.6'):
            r = self.run(self.edited('manual/rigid_tool', (r'LOAD 0 0 -5  0 0 0', 'LOAD 0.2 0.1 -5 0.2 -0.1 0'),
                                     (r'TURN FREE', 'TURN 0 0 1 0' if mu == '0' else 'TURN FREE')),
                         '--set', 'mu=' + mu)
            table = rigid_rows(r)
            for step, rows in r.con.items():
                t, tool = min(0.25*step, 1.0), table[step]['tool']
                for i, load in enumerate((0.2, 0.1, -5.0)):
                    self.near(f'mu {mu}: forces along x{i + 1} in step {step}', load*t + rows['1'][f'F{i + 1}']
                              + tool[f'F{i + 1}'], 0, 1e-8)

    def test_prescribed_rigid_body_is_a_displacement(self):
        changes = ((r'MOVE 0.02 0 FREE  2', 'MOVE 0 0 -0.003 1\n  MOVE 0.02 0 0 2'),
                   (r'TURN FREE', 'TURN 0 0 1 0'), (r'  LOAD  ?0 0 -5  0 0 0  1\n', ''))
        moved = (r'RIGId punch tool\n  MOVE 0.02 0 FREE  2\n  TURN FREE\n  LOAD 0 0 -5  0 0 0  1\n',
                 'SET punched\n  INSIde punch\n\nBOUNdary\n  punched 1 1 1\n\nDISPlacement\n'
                 '  punched 0 0 -0.003 1\n  punched 0.02 0 0 2\n')
        plain = self.run(self.edited('manual/rigid_tool', moved), '--solver', 'UMFP', out='plain')
        for solver in ('UMFP', 'REDU', 'AUTO'):
            rigid = self.run(self.edited('manual/rigid_tool', *changes), '--solver', solver)
            self.agree(f'{solver}: a body that is moved', rigid, plain, 1e-9)
        self.true('AUTO takes REDUced', b'solver: REDUced' in rigid.text('.log'))

    def test_shrink_fit(self):
        shutil.copy(os.path.join(GALLERY, 'shrunk.msh'), self.folder)
        r = self.input('gallery/shrink_fit')
        pressure = {step: rows['fit']['Fn']/(0.1*math.pi) for step, rows in r.con.items()}
        self.near("Lame's pressure", pressure[4], 0.3110047846889953, 0.001*0.311)
        for step in range(1, 4):
            self.near(f'in proportion, step {step}', pressure[step], 0.25*step*pressure[4], 0.001*pressure[4])
        once = self.run(self.edited('gallery/shrink_fit', (r'    SHRInk  1\n', ''), (r'1/4', '1'),
                                    (r'STEP,,4', 'STEP,,1')), out='once')
        self.near('the way does not matter', once.con[1]['fit']['Fn'], r.con[4]['fit']['Fn'], 1e-9)
