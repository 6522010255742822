"""What small strain cannot mean ends a run: tests of tests/properties/run, which mixes this class in."""
import os
import re

import decks

DECKS = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'decks')


class LimitLaws:
    """Tests of the limits of a linear theory and of bodies thrown out of contact; self.run,
    self.edited, self.failing, self.near, self.true: from Suite."""

    def test_a_plank_that_statics_forbids_ends_the_run(self):
        """It leans with too little friction: no turn by 90 degrees is its place of rest. Statics is
        what is said first, with --quiet too; no row is written."""
        for batch in (('', ''), ('STEP,,3', 'LOOP,,3\n  TIME\n  LOOP,,90\n  TANG,,1\n  NEXT\n  NEXT')):
            deck = self.edited('plank_falls', batch, source=DECKS)
            done = decks.run(self.program, [deck, '--out', self.folder, '--quiet'], self.folder, 120)
            self.true(f'exit code {done.code}', done.code == 2)
            self.true(f'no row: {self.rows_of("edited")}', not self.rows_of('edited'))
            if batch[0]:
                continue
            self.true(f'what statics says: {done.err}', self.says_that_it_slides(done.err))
        deck = self.edited('plank_falls', ('COULomb 0.1', 'COULomb 0.02'), ('COULomb 0.05', 'COULomb 0.3'), source=DECKS)
        done = decks.run(self.program, [deck, '--out', self.folder, '--quiet'], self.folder, 120)
        self.true(f'exit code {done.code}', done.code == 2)
        self.true(f'what statics says: {done.err}', self.says_that_it_slides(done.err))
        self.true(f'how far it has turned: {done.err}', re.search(
            r'\(region plank\) has rotated by \d+ degrees as a whole, and may by 18.1', done.err))

    @staticmethod
    def says_that_it_slides(err):
        """The first line of an error says so."""
        said = err[err.find('error:'):].split('\n')  # after warnings
        return re.match(r'  nothing holds it where it is: the body of element 1 \(region plank\) slides along',
                        said[1] if 'tried:' not in said[1] else said[2])

    def rows_of(self, name):
        """Rows of reactions that a run has left in the folder of the test."""
        with open(os.path.join(self.folder, name + '.rea'), encoding='ascii') as stream:
            return [line for line in stream if not line.startswith('#')]

    def test_a_clamped_block_is_not_thrown_out(self):
        """Between a floor and a stamp, beside another pair that keeps its force: Newton's iteration
        had thrown it out. Half the increments give -191.13."""
        deck = os.path.join(DECKS, 'clamped_block.inp')
        for solver in ('REDUced', 'UMFPack'):
            r = self.run(deck, '--solver', solver, out=solver)
            self.near(f'{solver}: R3 of the stamp', r.rea[12]['stamp_top'][2], -191.15, 0.05)
            self.near(f'{solver}: the floor', r.con[12]['lower']['F3'], 191.15, 0.05)

    def test_a_volume_that_changes_by_a_tenth_ends_the_run(self):
        """Two blocks pressed into each other, in equal increments: the same end time is the first
        that is refused, whether displacements inside are known there or not."""
        changes = [('DT,,1/2\n  STEP,,2', 'DT,,1/40\n  STEP,,40')]
        for name, more in (('known', []), ('sums', [('\nEND\nBATCh', '\nOUTPut\n  FIELds NONE\n  STATe NONE\n\nEND\nBATCh')])):
            for form in ('NTOS      sole slab', 'GTOS sole slab'):
                deck = self.edited('audited_blocks', ('NTOS      sole slab', form), *changes, *more,
                                   source=DECKS)
                done = decks.run(self.program, [deck, '--set', 'depth=0.4', '--set', 'nu=0', '--out',
                                                self.folder], self.folder, 120)
                self.true(f'{name}: {done.err}', done.code == 2 and re.search(
                    r'the volume of the body of element \d+ \(region \w+\) has changed by -1\d\.\d %', done.err))
                last = max((int(line.split()[0]) for line in self.rows_of('edited')), default=0)
                self.true(f'{name}, {form}: {last} end times, 18 to 20 wanted', 18 <= last <= 20)

    def test_a_variant_that_small_strain_cannot_mean_fails(self):
        """Blocks pressed by up to a fifth of both: on the factors of the run and on factors of their
        own the variants end where a run of their values ends."""
        deck = self.edited('audited_blocks', ('DT,,1/2', 'DT,,1/8'), ('STEP,,2', 'STEP,,8'), source=DECKS)
        for values, name, vary in ((['nu=0'], 'depth', '0.01,0.31,0.41'), (['depth=0.31'], 'nu', '0,0.1,0.3')):
            items = [item for value in values for item in ('--set', value)]
            if name == 'depth':
                items += ['--set', 'depth=0.02']
            else:
                items += ['--set', 'nu=0.4']
            decks.run(self.program, [deck, '--out', self.folder, '--vary', f'{name}={vary}', *items],
                      self.folder, 120)
            with open(os.path.join(self.folder, 'edited.study'), encoding='ascii') as stream:
                ends = [line.split()[1:4] for line in stream if not line.startswith('#')]
            self.true(f'{name}: variants {ends}', len(ends) == 3)
            for value, code, step in ends:
                alone = decks.run(self.program, [deck, '--out', self.folder, *items, '--set',
                                                 f'{name}={value}'], self.folder, 120)
                rows = {int(line.split()[0]) for line in self.rows_of('edited')}
                self.true(f'{name} {value}: exit {code} at {step}, alone {alone.code} at {rows}',
                          int(code) == alone.code and int(step) == max(rows, default=0))
            self.true(f'{name}: some fail: {ends}', {code for _, code, _ in ends} == {'0', '2'})

    def test_regions_that_turn_as_wholes_may_turn_far(self):
        """ROTAtion of all nodes and TURN of a rigid body are no strain, whatever their angle."""
        for name in ('turned_disc', 'turning_disc', 'turning_pin'):
            r = self.run(os.path.join(decks.TOP, 'inputs', 'manual', name + '.inp'), out=name)
            self.true(f'{name}: rows', len(r.con) > 0)
