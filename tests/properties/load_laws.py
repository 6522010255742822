"""What mechanics says of loads: tests of tests/properties/run, which mixes this class in.

Block and base of decks/loaded_block.inp; a test adds its loads, and what they come to is known.
"""
import math
import os

HERE = os.path.dirname(os.path.abspath(__file__))
DECKS = os.path.join(HERE, 'decks')
RAMPS = ('PROPortional 1\n  0 0\n  1 1\n  2 1\n', 'PROPortional 2\n  0 0\n  1 0\n  2 1\n')


class LoadLaws:
    """Tests of loads; self.run, self.edited, self.near, self.true and self.agree come from Suite."""

    def loaded(self, loads, *arguments, out='out', changes=()):
        """A run of the block with these data sets added."""
        sets = '\n\n'.join(loads) + '\n\nOUTPut'
        deck = self.edited('loaded_block', (r'OUTPut', lambda m: sets), *changes, source=DECKS)
        return self.run(deck, *arguments, out=out)

    def test_loads_of_several_tables_add(self):
        split = self.loaded(RAMPS + (
            'DISPlacement\n  top 0 0 -0.006 1\n  top 0.15 0.07 0 2\n  top 0 0 -0.004 1\n'
            '  top 0.001 0 0 1\n  top 0 0 -0.001 2',
            'FORCe\n  edge 0 0 -0.5 1\n  edge 0.25 0 0 2\n  edge 0 0 -0.5 2'), '--solver', 'UMFP')
        plain = self.loaded((
            'PROPortional 3\n  0 0\n  1 0.001\n  2 0.151\n',
            'PROPortional 4\n  0 0\n  1 0\n  2 0.07\n', 'PROPortional 5\n  0 0\n  1 -0.01\n  2 -0.011\n',
            'PROPortional 6\n  0 0\n  1 0\n  2 0.25\n', 'PROPortional 7\n  0 0\n  1 -0.5\n  2 -1\n',
            'DISPlacement\n  top 1 1 1', 'FORCe\n  edge 1 0 1',
            'FPROportional\n  top 3 4 5\n  edge 6 0 7'), '--solver', 'UMFP', out='plain')
        self.agree('one table for each sum', split, plain, 1e-10)
        condensed = self.loaded(RAMPS + (
            'DISPlacement\n  top 0 0 -0.006 1\n  top 0.15 0.07 0 2\n  top 0 0 -0.004 1\n'
            '  top 0.001 0 0 1\n  top 0 0 -0.001 2',
            'FORCe\n  edge 0 0 -0.5 1\n  edge 0.25 0 0 2\n  edge 0 0 -0.5 2'), '--solver', 'REDU',
            out='condensed')
        self.true('solved condensed', b'solver: REDUced' in condensed.text('.log'))
        self.agree('condensed', condensed, split, 1e-10)

    def test_faces_are_numbered_as_the_file_has_them(self):
        wanted = {'right': {1: (0, 0, -3), 2: (0, -3, 0), 4: (-3, 0, 0)},
                  'left': {1: (0, 0, -3), 2: (-3, 0, 0), 4: (0, -3, 0)}}
        for hand, nodes in (('right', '1,2,3,4'), ('left', '1,3,2,4')):
            with open(os.path.join(self.folder, 'm.inc'), 'w', encoding='ascii') as stream:
                stream.write('*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=E\n'
                             f'1, {nodes}\n*NSET,NSET=all\n1,2,3,4\n' + ''.join(
                                 f'*SURFACE,NAME=s{k}\n1,S{k}\n' for k in (1, 2, 4)))
            for face, force in wanted[hand].items():
                deck = os.path.join(self.folder, f'{hand}{face}.inp')
                with open(deck, 'w', encoding='ascii') as stream:
                    stream.write('MFEC * * faces\nMESH m.inc\nMATErial 1\n  ELAStic ISOTropic 1000 0.3\n'
                                 f'BOUNdary\n  all 1 1 1\nPRESsure\n  s{face} 6\nOUTPut\n'
                                 '  REACtions all\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')
                found = self.run(deck, out=f'{hand}{face}').rea[1]['all']
                for i in range(3):
                    self.near(f'{hand}-handed, S{face}: R{i + 1}', found[i], force[i], 1e-12)

    def test_forces_on_supports_are_reactions(self):
        for solver in ('UMFP', 'REDU'):
            bare = self.loaded(RAMPS + ('DISPlacement\n  top 0 0 -0.01 1',), '--solver', solver)
            forced = self.loaded(RAMPS + (
                'DISPlacement\n  top 0 0 -0.01 1', 'FORCe\n  bottom 0 2 -3 1\n  top 1 0 0 2'),
                '--solver', solver, out='forced')
            for step, sets in forced.rea.items():
                t = 0.5*step
                wanted = {'bottom': (0, -2*min(t, 1)*20, 3*min(t, 1)*20), 'top': (-max(t - 1, 0)*9, 0, 0)}
                for name, more in wanted.items():
                    for i in range(3):
                        self.near(f'{solver}: R{i + 1} of {name} in step {step}', sets[name][i],
                                  bare.rea[step][name][i] + more[i], 1e-9)

    def test_weight_is_carried(self):
        block, base = 2*0.79*0.66*0.6, 3*1.7*1.3*0.5
        rigid = (r'SOLId LINEar\n  ELAStic ISOTropic 2000 0.25', 'RIGId')
        for solver in ('UMFP', 'REDU'):
            for what, loads, changes, mass in (
                    ('all', ('GRAVity 1 2 -10',), (), block + base),
                    ('one region', ('GRAVity\n  1 2 -10 IN base',), (), base),
                    ('twice', ('GRAVity 0.25 0.5 -2.5', 'GRAVity\n  0.5 1 -5 0 IN base\n'
                               '  0.25 0.5 -2.5 IN base\n  0.75 1.5 -7.5 IN block'), (), block + base),
                    ('rigid base', ('GRAVity 1 2 -10',), (rigid,), block + base)):
                r = self.loaded(RAMPS + ('DISPlacement\n  top 0 0 -0.01 1',) + loads, '--solver',
                                solver, changes=changes)
                for step, sets in r.rea.items():
                    for i, g in enumerate((1, 2, -10)):
                        wanted = -0.5*step*g*mass
                        self.near(f'{solver}, {what}: R{i + 1} in step {step}',
                                  sets['top'][i] + sets['base'][i], wanted, 1e-9)

    def test_pressure_and_traction_are_carried(self):
        for solver in ('UMFP', 'REDU'):
            for what, loads, wanted in (
                    ('pressure on a free face', 'PRESsure\n  flank 3 2', (-3*0.66*0.6, 0, 0)),
                    ('pressure on a support', 'PRESsure\n  lid 1 2\n  lid 2 2', (0, 0, 3*0.79*0.66)),
                    ('traction', 'TRACtion\n  flank 1 -2 0.5 2', (-0.396, 0.792, -0.198))):
                r = self.loaded(RAMPS + ('DISPlacement\n  top 0 0 -0.01 1', loads), '--solver', solver)
                for step, sets in r.rea.items():
                    for i in range(3):
                        self.near(f'{solver}, {what}: R{i + 1} in step {step}', sets['top'][i] +
                                  sets['bottom'][i], wanted[i]*max(0.5*step - 1, 0), 1e-10)

    def test_loads_do_not_depend_on_the_solver(self):
        loads = RAMPS + ('DISPlacement\n  top 0 0 -0.01 1\n  top 0.02 0.01 0 2', 'GRAVity 1 2 -3 2',
                         'PRESsure\n  flank 0.5 1', 'TRACtion\n  flank 0 0.25 0 2')
        runs = [self.loaded(loads, '--solver', solver, out=solver) for solver in ('UMFP', 'REDU')]
        self.agree('all of them', runs[1], runs[0], 1e-10)

    def test_pressure_all_around(self):
        for shape, corner in (('TET4', 36), ('TET10', 175)):
            r = self.run(self.edited('squeezed_body', ('TET4', shape), ('NODE 36', f'NODE {corner}'),
                                     source=DECKS))
            with open(r.base + '.his', encoding='ascii') as stream:
                row = [float(word) for word in stream.read().splitlines()[-1].split()[2:]]
            for k, (value, x) in enumerate(zip(row, (1.1, 1.3, 0.9))):
                self.near(f'{shape}: u{k + 1} of the far corner', value, -4*(1 - 2*0.3)/1000*x, 1e-14)

    def test_pressure_follows_a_region_of_finite_strain(self):
        """The same on neo-Hooke: sigma = -p I with the stretch that its law has."""
        def lack(stretch):
            volume = stretch**3
            return (g*(stretch**2 - 1) + lame*math.log(volume))/volume + 400
        g, lame, low, high = 500/1.3, 300/1.3/0.4, 0.5, 1.0
        for _ in range(100):
            middle = 0.5*(low + high)
            low, high = (middle, high) if lack(middle) < 0 else (low, middle)
        for shape, corner in (('TET4', 36), ('TET10', 175)):
            r = self.run(self.edited(
                'squeezed_body', ('TET4', shape), ('NODE 36', f'NODE {corner}'), ('skin 4', 'skin 400'),
                ('  ELAStic', '  SOLId NEOHookean\n  ELAStic'), ('DT,,1', 'DT,,0.5'), (
                    'STEP,,1', 'STEP,,2'), ('PRESsure', 'PROPortional 1\n  0 0\n  1 1\n\nPRESsure'),
                source=DECKS))
            with open(r.base + '.his', encoding='ascii') as stream:
                row = [float(word) for word in stream.read().splitlines()[-1].split()[2:]]
            for k, (value, x) in enumerate(zip(row, (1.1, 1.3, 0.9))):
                self.near(f'{shape}: u{k + 1} of the far corner', value, (low - 1)*x, 1e-10)
            self.true(f'{shape}: {r.costs()["iterations"]} iterations', r.costs()['iterations'] <= 10)

    def test_weight_of_ten_nodes(self):
        sums = []
        plane = (('3  1.2 0.9 0', '3  0.9 1 0'), ('6  1 0.1 1.2', '6  1.1 -0.2 1'),
                 ('7  1.1 1.3 0.9', '7  1 0.8 1'), ('8  0 1 1.1', '8  0 0.8 1'))
        for shape in ('TET4', 'TET10'):
            r = self.run(self.edited('squeezed_body', ('TET4', shape), ('NODE 36', 'NODE 1'), (
                r'skin 4', 'skin 0\n\nGRAVity 1 -2 3\n\nTRACtion\n  skin 3 4 5'), (
                r'0\.3\n', '0.3\n  DENSity 2\n'), (r'OUTPut', 'OUTPut\n  REACtions body'), *plane,
                source=DECKS))
            sums.append(r.rea[1]['body'])
        for i in range(3):
            self.near(f'R{i + 1} of TET10', sums[1][i], sums[0][i], 1e-11)
        self.true('and it is something', min(map(abs, sums[0])) > 1)

    def test_a_held_body_needs_no_supports(self):
        """Loads that balance each other: HOLD and no pair; what does not balance has exit code 2."""
        head = ('MFEC * * held\nMATErial 1\n  SOLId LAW\n  ELAStic ISOTropic 1000 0.3\nBLOCk bar\n  CART 2 2 4  MATErial 1  TET4\n'
                '  1 0 0 0\n  2 1 0 0\n  3 1 1 0\n  4 0 1 0\n  5 0 0 2\n  6 1 0 2\n  7 1 1 2\n  8 0 1 2\nSET top\n  PLANe 3 2\n'
                'SET bottom\n  PLANe 3 0\nSURFace lid FROM top\nSURFace base FROM bottom\n')
        tail = ('OUTPut\n  REACtions top bottom\n  HISTory NODE 1 3\n  HISTory NODE 45 3\nBATCh\n  DT,,0.5\n  STEP,,2\nEND\n')
        for law, long in (('LINEar', 0.01), ('NEOHookean', None)):
            for support in ('', 'BOUNdary\n  bottom 0 0 1\n'):
                deck = os.path.join(self.folder, 'held.inp')
                with open(deck, 'w', encoding='ascii') as stream:
                    stream.write(head.replace('LAW', law) + support + 'HOLD\n  bar\nTRACtion\n  lid 0 0 5\n  base 0 0 -5\n' + tail)
                r = self.run(deck)
                for name in ('top', 'bottom'):
                    for i in (0, 1, 2) if not support else (0, 1):
                        self.near(f'{law}: reaction of {name}', r.rea[2][name][i], 0, 1e-10)
                ends = [float(x) for x in r.text('.his').decode().split()[-2:]]
                self.true(f'{law}: the log has its reaction', b'without resistance and is held; the reaction' in r.text('.log'))
                if long:
                    self.near(f'{law}: longer by', ends[1] - ends[0], long, 1e-12)
            with open(deck, 'w', encoding='ascii') as stream:
                stream.write(head.replace('LAW', law) + 'HOLD\n  bar\nTRACtion\n  lid 0 0 5\n' + tail)
            code, said = self.failing_deck(deck)
            self.true(f'{law}: {code} {said}', code == 2 and 'HOLD alone stops it there' in said)

    def test_springs_take_their_share(self):
        runs = [self.input('manual/sprung_post', '--solver', solver, out=solver)
                for solver in ('UMFP', 'REDU')]
        self.true('solved condensed', b'solver: REDUced' in runs[1].text('.log'))
        self.agree('REDUced', runs[1], runs[0], 1e-10)
        for step, sets in runs[0].rea.items():
            self.near(f'R1 in step {step}', sets['plate'][0] + sets['back'][0],
                      -0.6*max(0.5*step - 1, 0), 1e-10)
        for step in (11, 12):
            self.near(f'friction in step {step}', runs[0].rea[step]['plate'][0], -0.3*2.4525, 1e-3)

    def test_springs_follow_their_nodes(self):
        spring = ('SET knot\n  NODEs 10', 'SPRIng\n  knot 5 0 4\n  knot 0 7 7\n  bottom 100 100 100')
        change = ((r'REACtions', 'REACtions knot'), (r'FIELds    contact', 'HISTory NODE 10 1\n'
                  '  HISTory NODE 10 2\n  HISTory NODE 10 3'))
        for solver in ('UMFP', 'REDU'):
            r = self.loaded(RAMPS + ('DISPlacement\n  top 0 0 -0.01 1\n  top 0.1 0.05 0 2',) + spring,
                            '--solver', solver, changes=change)
            with open(r.base + '.his', encoding='ascii') as stream:
                moved = [line.split() for line in stream if line[0] != '#']
            for words in moved:
                for i, k in enumerate((5, 7, 11)):
                    self.near(f'{solver}: spring {i + 1} in step {words[0]}',
                              r.rea[int(words[0])]['knot'][i], -k*float(words[2 + i]), 1e-11)
            for step, sets in r.rea.items():
                c = r.only(step)
                for i in range(3):
                    self.near(f'{solver}: balance {i + 1} in step {step}', sets['top'][i] +
                              sets['knot'][i], -c[f'F{i + 1}'], 1e-10)

    def test_lay_turns_with_its_disc(self):
        for solver in ('UMFP', 'REDU'):
            r = self.input('manual/turning_disc', '--solver', solver, out=solver)
            for step in range(2, 74):
                r1, r2, r3 = r.rea[step]['top']
                a = math.radians(5*(step - 1) - 2.5)
                mu = 1/math.hypot(math.sin(a)/0.3, math.cos(a)/0.1)
                self.near(f'{solver}: friction in step {step}', math.hypot(r1, r2)/abs(r3)/mu, 1, 0.01)
                # an increment turns by 5 degrees: friction has the direction of the chord
                self.near(f'{solver}: its direction in step {step}', math.degrees(math.atan2(r1, -r2)),
                          2.5, 0.5)

    def test_rotation_about_any_axis(self):
        """A rigid base that turns; what is prescribed adds, and its corner goes on a circle. The block
        is rigid, too: no small strain bears how far the base would turn it."""
        rigid = (r'SOLId LINEar\n  ELAStic ISOTropic 1000 0.3', 'RIGId'), (
            r'SOLId LINEar\n  ELAStic ISOTropic 2000 0.25', 'RIGId'), (r'  bottom  1 1 1\n', ''), (
            r'  top     1 1 1\n', ''), ('PENAlty   AUTO', 'PENAlty   AREA 1000'), (
            r'FIELds    contact', '\n  '.join(f'HISTory NODE 28 {i}' for i in (1, 2, 3)))
        turn = ('ROTAtion\n  base 0.5 0.25 -1  0.6 0 0.8  200  1', 'DISPlacement\n  base 0 0 -5 2')
        r = self.loaded(RAMPS + turn, changes=rigid)
        with open(r.base + '.his', encoding='ascii') as stream:
            moved = [[float(w) for w in line.split()] for line in stream if line[0] != '#']
        arm, axis = (-0.5, -0.25, 0.5), (0.6, 0, 0.8)
        for step, t, *u in moved:
            angle = math.radians(200*min(t, 1))
            dot = sum(a*b for a, b in zip(arm, axis))
            across = [axis[i - 2]*arm[i - 1] - axis[i - 1]*arm[i - 2] for i in range(3)]
            for i in range(3):
                place = arm[i]*math.cos(angle) + across[i]*math.sin(angle) + axis[i]*dot*(1 - math.cos(angle))
                self.near(f'u{i + 1} at time {t}', u[i], place - arm[i] - (5*max(t - 1, 0) if i == 2 else 0),
                          1e-12)
