"""What mechanics says of laws of friction: tests of tests/properties/run, which mixes this class in."""
import math
import os

HERE = os.path.dirname(os.path.abspath(__file__))
DECKS = os.path.join(HERE, 'decks')


class FrictionLaws:
    """Tests of laws; self.run and self.near come from Suite."""

    def test_softening_friction_sticks_up_to_its_static_limit(self):
        # a block pressed by 10 on a rigid floor, mu .5 that falls to .2, drawn by a rope that is 200
        # times softer than the block: the pull grows by 6 a unit of time from t = 1 on
        for form in ('GTOS bottom ground_s', 'NTOS low ground_s', 'GTOS bottom ground_s SEGMent'):
            deck = self.edited('soft_rope', ('GTOS bottom ground_s', form), source=DECKS)
            for n in (7, 20):
                run = self.run(deck, '--set', f'n={n}')
                stretch = run.rea[2]['far'][0]*n/6.0
                for step, sets in run.rea.items():
                    pull = 6.0*(step - 1)/n
                    what = f'{form}, {n} increments, pull {pull:.3f}'
                    if pull < 4.5:
                        self.near(what, sets['far'][0], stretch*pull, 2e-3*5.0)
                    elif pull > 5.1:
                        self.near(what, sets['far'][0], 2.0, 2e-3*5.0)

    def test_no_multiplier_across_where_nothing_moves(self):
        # the normals of facets tilt across by thousandths, and so may the force, but not by a hundredth
        for points in ('', '7', 'SEGMent'):
            for press in (1, 4):
                run = self.run(self.edited('held_across', ('GTOS bottom ground_s', 'GTOS bottom '
                                                           f'ground_s {points}'), ('DT,,1\n  STEP,,1',
                                           f'DT,,{1/press}\n  STEP,,{press}'), source=DECKS))
                for step, pairs in run.con.items():
                    row = pairs['1']
                    self.near(f'{points} {press}: friction across at step {step}', row['F2']/row['Fn'],
                              0.0, 2e-4)

    def test_a_thin_fit_of_smooth_rings_presses_as_lame_says(self):
        # E 1000, nu .3, plane strain, radii .5, 1, 2, overlap 2e-4: the facets are 1e-2 and 6e-3 deep
        lame = 1000/(1 - 0.3**2)*2e-4*(4 - 1)*(1 - 0.25)/(2*(4 - 0.25))
        for form in ('GTOS s_skin s_bore', 'GTOS s_bore s_skin', 'GTOS s_skin s_bore SEGMent',
                     'NTOS s_skin s_bore', 'NTOS s_bore s_skin'):
            run = self.run(self.edited('thin_fit', ('GTOS s_skin s_bore', form), source=DECKS))
            pressure = run.only(2)['Fn']/(0.25*math.tau*0.3)
            self.near(form, pressure/lame, 1.0, 0.035)
            self.near(form + ', half of it', run.only(1)['Fn']/run.only(2)['Fn'], 0.5, 0.02)
