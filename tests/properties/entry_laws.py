"""What mechanics says of bodies that one increment leads deep into others: tests of
tests/properties/run, which mixes this class in.
"""
import os

DECKS = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'decks')


class EntryLaws:
    """Tests of large increments; self.run, self.edited, self.near, self.true, self.agree: from
    Suite."""

    def in_parts(self, name, old, form, parts, *arguments):
        """A deck of one increment with another form of contact, and in so many increments."""
        deck = self.edited(name, *old(form), ('DT,,1', f'DT,,1/{parts}'),
                           ('STEP,,1', f'STEP,,{parts}'), source=DECKS)
        out = f'{name}{form.replace(" ", "")}{parts}'
        return self.run(deck, *arguments, out=out), out

    @staticmethod
    def bent(form):
        """Changes of bent_plate.inp."""
        return [(f'GTOS {slave} {master} SEGMent', form.replace('S M', f'{slave} {master}'))
                for slave, master in (('sole', 'face'), ('back', 'leftseat'), ('back', 'rightseat'))]

    @staticmethod
    def slid(form):
        """Changes of over_the_rim.inp."""
        return [('GTOS under face SEGMent', form.replace('S M', 'under face'))]

    def test_a_punch_does_not_pass_through_a_plate(self):
        """The way of the punch in one increment is 0.4 to 5 times the thickness of the plate: the
        supports carry what it presses, as in ten increments."""
        for thick in (0.24, 0.04, 0.02):
            runs = [self.in_parts('bent_plate', self.bent, 'GTOS S M SEGMent', n, '--set',
                                  f'thick={thick}')[0] for n in (1, 10)]
            forces = [-r.rea[n]['top'][2] for r, n in zip(runs, (1, 10))]
            self.true(f'thickness {thick}: the punch presses by {forces[0]}', forces[0] > 0.1)
            self.near(f'thickness {thick}: in one increment over in ten', forces[0]/forces[1], 1, 0.02)
            self.near(f'thickness {thick}: the supports', runs[0].rea[1]['low'][2]/forces[0], 1, 1e-8)

    def test_a_punch_is_met_again_after_a_restart(self):
        deck, out = self.in_parts('bent_plate', self.bent, 'GTOS S M SEGMent', 2)
        again = self.run(os.path.join(self.folder, 'edited.inp'), '--restart',
                         os.path.join(self.folder, out, 'edited.vtkhdf'), '--step', '1', out='again')
        self.true('the second increment, to the bit', again.rea[2] == deck.rea[2]
                  and again.con[2] == deck.con[2] and deck.con[2]['above']['Fn'] > 0.1)

    def test_a_block_does_not_pass_through_the_rim(self):
        """A block that was beside a plate, and over no facet of it, comes in over its rim."""
        for form in ('GTOS S M SEGMent', 'GTOS S M 3', 'GTOS S M 6', 'NTOS S M'):
            runs = [self.in_parts('over_the_rim', self.slid, form, n)[0] for n in (1, 8)]
            forces = [-r.rea[n]['top'][2] for r, n in zip(runs, (1, 8))]
            self.near(f'{form}: in one increment over in eight', forces[0]/forces[1], 1, 0.2)
            self.near(f'{form}: the plate', runs[0].rea[1]['low'][2]/forces[0], 1, 1e-8)

    def test_what_nobody_foresaw_touches_in_the_condensed_form(self):
        """A beam bends far beyond what its supports carry it: the floor carries the same with each
        solver, in one increment and in four."""
        for form in ('GTOS lower track SEGMent', 'GTOS lower track 6', 'NTOS lower track'):
            for load in (1, 3):
                forces = []
                for solver, parts in (('UMFPack', 4), ('UMFPack', 1), ('REDUced', 1), ('REDUced', 4)):
                    deck = self.edited('bending_beam', ('GTOS lower track SEGMent', form),
                                       ('DT,,1', f'DT,,1/{parts}'), ('STEP,,1', f'STEP,,{parts}'),
                                       source=DECKS)
                    r = self.run(deck, '--solver', solver, '--set', f'load={load}', out=f'{solver}{parts}')
                    rows = r.rea[parts]
                    forces.append(rows['ground'][2])
                    self.near(f'{form}, {solver}: balance', rows['ground'][2] + rows['fix'][2],
                              0.4*load, 1e-8)
                self.true(f'{form}: the floor carries {forces[0]}', forces[0] > 0.1)
                for k in (1, 2, 3):
                    self.near(f'{form}, load {load}, run {k}', forces[k]/forces[0], 1, 1e-3)

    def test_plates_that_fall_far_are_carried(self):
        """Plates that contact alone holds are taken along by an increment, far through the air."""
        for form in ('NTOS low high', 'GTOS low high', 'GTOS low high SEGMent'):
            for gap, parts in ((0.8, 1), (1.5, 1), (1.5, 3)):
                for solver in ('UMFPack', 'REDUced'):
                    deck = self.edited('thin_plates', ('GTOS low high', form), ('STEP,,4', f'STEP,,{parts}'),
                                       ('DT,,0.25', f'DT,,1/{parts}'), source=DECKS)
                    r = self.run(deck, '--solver', solver, '--set', f'gap={gap}', out=f'{solver}{parts}')
                    foot, joints = r.con[parts]['foot']['Fn'], r.con[parts]['joints']['Fn']
                    self.true(f'{form}, {gap}, {solver}: the floor carries {foot}', foot > 1.0)
                    self.near(f'{form}, {gap}, {solver}: two joints', joints, 2.0*foot, 1e-3*foot)

    def test_what_nobody_foresaw_touches_without_fields(self):
        """The same where displacements inside are not written, and so not found, for long."""
        forces = []
        for solver in ('UMFPack', 'REDUced'):
            deck = self.edited('bending_beam', ('DT,,1', 'DT,,1/20'), ('STEP,,1', 'STEP,,20'),
                               ('REACtions fix ground', 'REACtions fix ground\n  FIELds NONE\n'
                                '  STATe NONE\n  EVERy 100'), source=DECKS)
            r = self.run(deck, '--solver', solver, out=solver)
            forces.append([r.rea[step]['ground'][2] for step in range(1, 21)])
        self.true('the floor carries', forces[0][9] > 0.1)
        for step, (right, force) in enumerate(zip(*forces), 1):
            self.near(f'step {step}', force, right, 1e-6)

    def test_a_body_that_flies_lands(self):
        """A cube falls by 1, 2.4 and 5 of its edges in one increment, with the solver that AUTO
        takes in the end: the floor carries its weight."""
        for height in (0.5, 1.2, 2.5):
            run = self.run(os.path.join(DECKS, 'dropped_cube.inp'), '--set', f'height={height}',
                           out=f'dropped_{height}')
            self.near(f'height {height}: the floor', run.rea[1]['ground'][2], 0.25, 1e-9)

    def test_a_falling_body_does_not_go_aside(self):
        """What nothing holds along x1 but friction at points still to touch stays over its place."""
        sprung = os.path.join(DECKS, 'sprung_in_corner.inp')
        for words in ((), (('NTOS under track', 'GTOS under track\n    AUGMent'), ('NTOS left', 'GTOS left'))):
            deck = self.edited('sprung_in_corner', *words, source=DECKS) if words else sprung
            whole = self.run(deck, '--solver', 'UMFP', out='whole')
            for solver in ('REDU', 'CHOL'):
                self.agree(f'{solver}, {words}', self.run(deck, '--solver', solver, out=solver), whole, 1e-7)
            self.near(f'the wall is not touched on the way down, {words}', whole.con[2]['wall']['active'], 0, 0)
        for solver in ('REDU', 'UMFP'):
            smooth = self.run(sprung, '--solver', solver, '--set', 'mu=0', out='smooth')
            self.near(f'{solver}: nothing drives it against the wall', smooth.con[2]['wall']['active'], 0, 0)
            ends = [float(x) for x in [x for x in smooth.text('.his').decode().splitlines() if x[0] != '#'][1].split()[2:]]
            self.near(f'{solver}: it bulges to both sides', abs(sum(ends))/abs(ends[1] - ends[0]), 0, 1)

    def test_a_body_in_balance_does_not_fall(self):
        """Pulled at both ends by the same, far over a floor: the sum of its loads is round-off and drives it nowhere."""
        for law in ('LINEar', 'NEOHookean'):
            deck = self.edited('dropped_cube', (r'GRAVity\n  0 0 -1 IN cube', 'TRACtion\n  under 0 0 -3\n  lid 0 0 3\nHOLD\n  cube'),
                               (r'SURFace under', 'SET cap\n  PLANe 3 height+0.5\nSURFace lid FROM cap IN cube\nSURFace under'),
                               (r'SOLId LINEar', f'SOLId {law}'),
                               (r'BATCh', 'OUTPut\n  HISTory NODE 1 3\nBATCh'), source=DECKS)
            # without contact REDUced does not hold a body of finite strain: AUTO takes the whole system then
            for solver in ('UMFP', 'AUTO' if law == 'NEOHookean' else 'REDU'):
                r = self.run(deck, '--solver', solver)
                down = float(r.text('.his').decode().split()[-1])
                self.near(f'{law}, {solver}: its lower end', down, 0, 0.01)

