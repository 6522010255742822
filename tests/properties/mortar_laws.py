"""What mechanics says of multipliers at nodes (MORTar): tests of tests/properties/run, which mixes
this class in.
"""
import os

import h5py

from mortar_decks import (E, PRESSURE, cushion, dragged, held_rims, in_corner, kinked, lame, on_thirds, on_two, pile, resting, rings,
                          sprung, two_blocks)
from rigid_laws import rigid_rows


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
            r = self.strained('mortar_patch', text, (0.3, 0.3, -1), what)
            c = r.only(1)
            self.near(what + ': force', c['F3'], PRESSURE, 1e-9)
            if tilt == 0:  # nodes on a symmetry plane hand the part along its normal to their supports
                self.near(what + ': friction', c['Ft'], 0, 1e-9)
            self.near(what + ': no penetration', c['max_penetration'], 0, 1e-12)

    def strained(self, name, text, strains, what, within=1e-10):
        """Runs a deck; its displacements are those of even strains, in units of the pressure over E."""
        r = self.run(self.written(name, text))
        with h5py.File(r.base + '.vtkhdf') as file:
            grid = file['VTKHDF']
            x, u = grid['Points'][:], grid['PointData/displacement'][-len(grid['Points']):]
        moves = (x[:, 2] > 1e-9) & (x[:, 0] > 1e-9)  # not those of rigid bodies
        error = max(abs(u[:, k] - PRESSURE/E*x[:, k]*strains[k])[moves].max() for k in range(3))
        self.near(what + ': displacements', error*E/PRESSURE, 0, within)
        return r

    def test_nodes_in_two_pairs(self):
        """A node may have multipliers of several pairs: side by side, or across an edge."""
        for below in ((2, 3), (1, 1), (4, 7)):
            r = self.strained('mortar_seam', on_two(below), (0, 0, -1), f'a seam, {below} cells below')
            self.near('force left', r.con[1]['1']['F3'], 0.45*PRESSURE, 1e-9)
            self.near('force right', r.con[1]['2']['F3'], 0.55*PRESSURE, 1e-9)
        for kind in ('TET4', 'TET10'):
            r = self.strained('mortar_corner', in_corner(kind), (-0.5 + 0.3, 0.3*1.5, -1 + 0.3*0.5),
                              'a corner, ' + kind)

    def test_other_forms_beside_it(self):
        """A pair with a penalty beside one with multipliers: both carry the pressure, and forces are
        those of stiff penalties in both."""
        own = 'MORTar over under'
        for other in ('GTOS above below', 'GTOS above below 6', 'NTOS above below'):
            r = self.run(self.written('mortar_beside', pile(own, other, True)))
            for pair in ('1', '2'):
                self.near(f'{other}: force of pair {pair}', r.con[1][pair]['F3'], PRESSURE, 1e-9)
            stiff = other + '\n    PENAlty AUTO 100'
            r = self.run(self.written('mortar_beside', pile(own, stiff, False)))
            both = self.run(self.written('stiff_beside', pile('GTOS over under SEGMent\n    PENAlty AUTO 1000', stiff,
                                                             False)))
            for step in r.con:
                for pair in ('1', '2'):
                    c, wanted = r.con[step][pair], both.con[step][pair]
                    for k in ('F1', 'F2', 'F3'):
                        self.near(f'{other}, row {step}: {k} of pair {pair}', c[k]/wanted['F3'],
                                  wanted[k]/wanted['F3'], 0.002)
                    self.near(f'{other}, row {step}: {pair} and lid', c['F3'], -r.rea[step]['lid'][2], 1e-9)
                self.true(f'{other}, row {step}: cone', r.con[step]['2']['Ft'] < 0.3*r.con[step]['2']['Fn']*(1 + 1e-6))

    def test_kinked_joints_are_one(self):
        """A multiplier a face: an even pressure goes through a joint with kinks. Where both sides have the same cells
        along x, the faces of a node at a kink have the same gaps, and their forces only a sum."""
        for form, below, above, slope, ten in (
                ('foot bed', (8, 3, 2), (4, 5, 2), 0.4, False), ('bed foot', (4, 3, 2), (8, 4, 2), 0.4, False),
                ('foot bed', (4, 4, 1), (4, 3, 1), 0.4, True), ('foot bed', (8, 4, 1), (4, 3, 1), 0.4, True),
                ('foot bed', (4, 2, 1), (4, 2, 1), 0.46, True), ('foot bed', (8, 2, 1), (8, 3, 2), 0.34, False),
                ('foot bed', (12, 4, 2), (12, 4, 2), 0.48, False), ('bed foot', (4, 3, 2), (4, 3, 1), 0.55, True),
                ('foot bed', (8, 5, 1), (12, 5, 2), 0.42, False)):
            self.strained('mortar_kink', kinked('MORTar ' + form, below, above, slope, ten), (0.3, 0.3, -1),
                          f'{form}, {below} under {above}')

    def test_adjusted_joint_is_even(self):
        """ADJUst moves the slave's nodes onto the master, from above and from below."""
        text = two_blocks('MORTar over under\n    ADJUst 1e-3', (2, 3, 2), (5, 4, 2), 0, 0.3, 'TET4')
        text = text.replace('BLOCk high', 'TRANsform\n  1 0 0\n  0 1 0\n  0 0 1\n  0 0 {}\nBLOCk high')
        for shift in (4e-4, -4e-4):
            deck = text.replace('{}', repr(shift)).replace('PLANe 3 2', f'PLANe 3 {2 + shift}')
            r = self.run(self.written('mortar_adjusted', deck.replace('0.99999', '0.999').replace('1.00001', '1.001')))
            self.near('force', r.only(1)['F3'], PRESSURE, 1e-9)
            self.near('friction', r.only(1)['Ft'], 0, 1e-9)
            self.near('no penetration', r.only(1)['max_penetration'], 0, 1e-12)

    def test_shrunk_ring_presses_like_lame(self):
        """SHRInk takes up the overlap of two rings: Lame's force on half the way and at its end."""
        for form in ('MORTar foot bed', 'MORTar bed foot'):
            for cells in ((6, 8), (9, 7)):
                r = self.run(self.written('mortar_rings', rings(form, cells)))
                for step in (1, 2):
                    self.near(f'{form}, {cells} cells: force', r.only(step)['Fn']/lame(), step/2, 0.006*step/2)

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

    def test_rigid_punch_finds_its_place(self):
        """A rigid body with a point, free to sink and to turn: its load is carried, its two turns are
        one by symmetry, and forces are those of a stiff penalty."""
        found = {}
        for form in ('MORTar floor skin', 'GTOS floor skin SEGMent\n    PENAlty AUTO 1000'):
            r = self.run(self.edited('manual/rigid_tool', (r'NTOS sole floor\s+PENAlty 1e4', form)), out=form[:4])
            found[form[:4]] = [(c['F1'], c['F3']) for c in map(r.only, sorted(r.con))]
            if form.startswith('MORT'):
                for step, row in rigid_rows(r).items():
                    self.near(f'row {step}: the load is carried', r.only(step)['F3'], -5*min(1, step/4), 1e-8)
                    if step <= 4:
                        self.near(f'row {step}: equal turns', row['tool']['ROT1'] + row['tool']['ROT2'], 0, 1e-12)
        for step, (own, other) in enumerate(zip(*found.values()), 1):
            self.true(f'row {step}: {own}, stiff {other}', max(abs(a - b) for a, b in zip(own, other)) < 0.05)

    def test_friction_decays_with_the_way_of_nodes(self):
        """DECAy: where all slips, friction is what the way of the nodes has left of it."""
        r = self.run(self.edited('mortar_blocks', ('ELLIptic 0.3 0.2', 'COULomb 0.3\n    DECAy 0.1 0.1 1e-3'),
                                 (r'lid  0.004 0 0  2', 'lid  0.016 0 0  2')))
        shares = [c['Ft']/c['Fn'] for c in map(r.only, sorted(r.con))]
        self.true(f'less and less friction: {shares}', all(a > b for a, b in zip(shares[2:], shares[3:])))
        self.near('the kinetic one at the end', shares[-1], 0.1, 5e-4)
        self.true('all slip at the end', r.only(6)['slip'] == r.only(6)['active'] > 0)

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
        """Compliance and factors serve an increment, few rounds settle the weights, and facets whose
        points rest are not cut again."""
        r = self.input('mortar_blocks')
        costs, steps = r.costs(), len(r.con)
        self.true(f'compliances: {costs}', steps <= costs['mortar compliances'] <= 2*steps)
        self.true(f'factors: {costs}', costs['dense factorisation'] <= 6*steps)
        self.true(f'rounds: {costs}', costs['mortar iterations'] <= 8*steps)
        facets = 2*5*4
        self.true(f'cuts: {costs}', 2*facets <= costs['segmented facets'] <= costs['contact search']*facets/2)
        self.true(f'weighed: {costs}', costs['mortar weights made'] <= 30*(costs['mortar iterations'] + 4*steps))

    def test_a_stack_is_held_by_friction(self):
        """Bodies that contact alone holds find their friction from nothing."""
        deck = self.edited('gallery/stack_on_slope', (r'GTOS    ', 'MORTar  '), (r'    PENAlty  AUTO\n', ''))
        r = self.run(deck)
        self.true('no cut', b' 0 cuts' in r.text('.log'))
        for name, weight in (('first_on_slope', 3), ('second_on_first', 2), ('third_on_second', 1)):
            self.near(name, r.con[4][name]['F3'], weight, 1e-9)

    def test_slivers_find_room(self):
        """Where edges lie on edges each slave facet is cut with many master facets, most of them in slivers."""
        for form in ('MORTar over under', 'GTOS over under SEGMent'):
            for n, kind in ((2, 'TET4'), (3, 'TET4'), (3, 'TET10')):
                r = self.run(self.written('mortar_thirds', on_thirds(form, n, kind)))
                self.true(f'{form}, {n} cells of {kind}: all points have room', b'storage for' not in r.text('.log'))

    def test_a_block_rests_far_from_the_origin(self):
        """A thousand sizes from the origin round-off of gaps is more than the tolerance of forces."""
        for kind in ('TET4', 'TET10'):
            for shift in ((0.0, 0.0, 0.0), (-593.5, -843.75, -212.25), (1000.5, -777.25, 333.5)):
                r = self.run(self.written('mortar_far', resting(shift, kind)))
                self.true(f'{kind} at {shift}: no cut', b' 0 cuts' in r.text('.log'))
                for k, load in enumerate((0.03, 0.02, -0.2)):
                    self.near(f'{kind} at {shift}: force {k + 1}', r.rea[1]['floor'][k], -0.52*load, 1e-9)

    def test_a_soft_cushion_between_stiff_blocks(self):
        """The tangent of a body that contact alone holds may lose definiteness under pressure: its
        compliance then has fewer digits, and the scale of the stiff blocks asks for too many."""
        for cells in (((3, 3, 1), (5, 5, 2), (3, 3, 1)), ((2, 3, 1), (7, 7, 2), (3, 2, 1))):
            r = self.run(self.written('mortar_cushion', cushion(cells)))
            self.true(f'{cells}: no cut', b' 0 cuts' in r.text('.log'))
            for step in r.con:
                for k in range(3):
                    self.near(f'{cells}, row {step}: force {k + 1}', r.rea[step]['floor'][k] + r.rea[step]['lid'][k], 0,
                              1e-9*abs(r.rea[step]['floor'][2]))

    def test_weak_springs_hold_a_cube(self):
        """A cube that springs alone hold where contact does not, 1e-4 to 1e-9 of its own stiffness: the floor
        bears the loads but for what the springs take, as with a penalty."""
        for cells, kind, springs in ((3, 'TET4', (1e-1, 1e-4, 1e-6)), (2, 'TET10', (1e-4,))):
            for spring in springs:
                rows = []
                for form in ('MORTar over under', 'GTOS over under'):
                    r = self.run(self.written('mortar_sprung', sprung(form, cells, kind, spring)), out=form[:4])
                    rows.append(r.only(8))
                what = f'{kind}, springs {spring:g}'
                for k, load in (('F1', -PRESSURE/4), ('F3', PRESSURE)):
                    self.near(f'{what}: {k} as GTOS', rows[0][k], rows[1][k], 1e-5 if spring < 1e-2 else 2e-3)
                    self.near(f'{what}: {k}', rows[0][k], load, 1e-3 if spring < 1e-2 else 0.1)

    def test_held_rims_carry_their_share(self):
        """Slave nodes that supports hold along the normal hand their share to others: an even pressure is
        exact, whatever is held where it goes by itself."""
        for kind, below, above in (('TET4', (4, 3, 2), (3, 3, 2)), ('TET10', (3, 2, 1), (2, 2, 1))):
            for tilt in (0, 0.3):
                for rims in ((0,), (0, 1)):
                    text = two_blocks('MORTar over under', below, above, tilt, 0.9, kind)
                    what = f'{kind}, slope {tilt}, rims {rims}'
                    # what is held goes ahead, and cells are not cut again for the last 1e-7 of a facet
                    r = self.strained('mortar_held', held_rims(text, rims, tilt), (0.3, 0.3, -1), what, 1e-8)
                    self.near(what + ': force', r.only(1)['F3'], PRESSURE, 1e-8)
                    self.true(what + ': not told', b'held along' not in r.text('.log'))

    def test_held_side_rubs(self):
        """A block whose side is held along the drag has its friction there, too; on a plane of symmetry nodes keep
        their multipliers."""
        for kind, below, above in (('TET4', (4, 3, 2), (3, 3, 2)), ('TET10', (3, 2, 1), (2, 2, 1))):
            text = dragged(two_blocks('MORTar over under', below, above, 0, 0.3, kind))
            c = self.run(self.written('mortar_dragged', text)).con[4]['1']
            self.near(f'{kind}: friction', c['Ft'], 0.3*c['Fn'], 1e-9)
            self.near(f'{kind}: drag', c['F1'], 0.3*PRESSURE, 0.05*PRESSURE)
            self.true(f'{kind}: fewer nodes', c['active'] == (12 if kind == 'TET4' else 20))
            c = self.run(self.written('mortar_symmetric', two_blocks('MORTar over under', below, above, 0, 0.3, kind)))
            self.true(f'{kind}: all nodes', c.only(1)['active'] == (16 if kind == 'TET4' else 25))

    def test_what_is_held_inside_is_told(self):
        """A face held far inside has its pressure on average; exchanged, everywhere."""
        text = two_blocks('MORTar over under', (4, 3, 1), (7, 7, 1), 0, 0.3, 'TET4')
        text = text.replace('CONTact', 'SET mid\n  INSIde high\n  BOX 0.1 0.9 0.1 0.9 0.9 1.1\nCONTact')
        text = text.replace('  x0 1 0 0', '  mid 0 0 1\n  x0 1 0 0').replace('TRACtion', (
            f'DISPlacement\n  mid 0 0 {-PRESSURE/E!r}\nTRACtion'))
        for form, told in (('MORTar over under', True), ('MORTar under over', False)):
            r = self.run(self.written('mortar_inside', text.replace('MORTar over under', form)))
            self.near(form + ': force', abs(r.only(1)['F3']), PRESSURE, 1e-9)
            self.true(form, (b'4 slave nodes held along the normal far' in r.text('.log')) == told)
