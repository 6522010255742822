"""Scenes drawn from seeds on which the penalty's share of force and approach is measured."""
import random

KINDS = ('ball', 'layer', 'punch', 'blocks', 'roller', 'loaded', 'dragged')


class Scene:
    """One deck with a place for its penalty."""

    def __init__(self, seed):
        self.seed = seed
        draw = random.Random(f'penalty {seed}')
        self.kind = KINDS[seed % len(KINDS)]
        self.element = draw.choice(('TET4', 'TET10'))
        self.form = draw.choice(('NTOS', 'GTOS', 'GTOS', 'SEGMent'))
        if self.form == 'NTOS' and self.element == 'TET10':
            self.form = 'GTOS'  # corners of six-node facets carry no force of an even pressure
        self.finite = draw.random() < 0.3
        self.nu = draw.choice((draw.uniform(0.2, 0.45), 0.5 - 10**draw.uniform(-4.0, -1.3)))
        self.modulus = 10**draw.uniform(-1.0, 5.5)
        self.size = 10**draw.uniform(-2.0, 2.0)
        self.mu = draw.choice((0.0, draw.uniform(0.1, 0.8)))
        if self.kind == 'dragged':
            self.mu = draw.uniform(0.1, 0.6)
        self.steps = 3
        self.lines = getattr(self, '_' + self.kind)(draw)

    def name(self):
        """What stands in the table."""
        return (f'{self.seed} {self.kind} {self.element} {self.form} '
                f'{"finite" if self.finite else "small"} nu {self.nu:.5g} mu {self.mu:.2g}')

    def deck(self, penalty):
        """The deck with a PENAlty record."""
        return '\n'.join(self.lines).replace('{penalty}', penalty) + '\n'

    # Parts of decks

    def _number(self, value):
        return repr(value*self.size)

    def _material(self, number=1, modulus=None, nu=None):
        law = 'NEOHookean' if self.finite else 'LINEar'
        return [f'MATErial {number}', f'  SOLId {law}',
                f'  ELAStic ISOTropic {(modulus or self.modulus)!r} {nu or self.nu!r}', '']

    def _block(self, name, low, high, cells, material=1):
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                   (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        lines = [f'BLOCk {name}', '  CART %d %d %d' % tuple(cells)
                 + f' MATErial {material} {self.element}']
        for number, corner in enumerate(corners, 1):
            place = [self._number(high[i] if corner[i] else low[i]) for i in range(3)]
            lines.append(f'  {number} ' + ' '.join(place))
        return lines + ['']

    def _plane(self, name, height, region):
        return [f'SET {name}', f'  PLANe 3 {self._number(height)}', f'  INSIde {region}', '']

    def _pair(self, slave, master, out):
        form = f'GTOS {slave} {master} SEGMent' if self.form == 'SEGMent' else \
            f'{self.form} {slave} {master}'
        friction = f'COULomb {self.mu!r}' if self.mu > 0 else 'NONE'
        return ['CONTact', '  PAIR 1 pair', f'    {form}', '    {penalty}',
                f'    FRICtion {friction}', '', 'OUTPut', f'  REACtions {out}',
                '  FIELds NONE', '', 'END', 'BATCh', f'  DT,,{1.0/self.steps!r}',
                f'  STEP,,{self.steps}', 'END', 'STOP']

    def _tool(self, draw, surface, centre, depth, cells, pad, way=(0.0, 0.0)):
        """A rigid surface pressed into a pad by a prescribed depth."""
        low, high = pad
        return (['MFEC * * drawn'] + self._material() + self._block('pad', low, high, cells)
                + self._plane('foot', low[2], 'pad') + self._plane('lid', high[2], 'pad')
                + ['SURFace top FROM lid', f'SURFace tool {surface}', '', 'BOUNdary', '  foot 1 1 1',
                   '', 'RIGId tool', '  POINt ' + ' '.join(self._number(c) for c in centre),
                   f'  MOVE {self._number(way[0])} {self._number(way[1])} {self._number(-depth)} 1',
                   '  TURN 0 1 0 0', '', 'PROPortional 1', '  0 0', '  1 1', '']
                + self._pair('top', 'tool', 'tool'))

    # Kinds

    def _ball(self, draw):
        cells = [draw.randint(4, 8), draw.randint(4, 8), draw.randint(2, 4)]
        radius, depth = draw.uniform(0.4, 2.0), draw.uniform(0.01, 0.08)
        place = draw.uniform(-0.2, 0.2), draw.uniform(-0.2, 0.2), radius
        return self._tool(draw, 'SPHEre ' + ' '.join(self._number(v) for v in (*place, radius)),
                          place, depth, cells, ((-1, -1, -1), (1, 1, 0)))

    def _roller(self, draw):
        cells = [draw.randint(5, 9), draw.randint(2, 4), draw.randint(2, 4)]
        radius, depth = draw.uniform(0.4, 2.0), draw.uniform(0.01, 0.06)
        x = draw.uniform(-0.2, 0.2)
        surface = 'CYLInder ' + ' '.join(self._number(v) for v in (x, 0, radius)) + ' 0 1 0 ' + \
            self._number(radius)
        return self._tool(draw, surface, (x, 0, radius), depth, cells, ((-1, -.5, -1), (1, .5, 0)))

    def _layer(self, draw):
        """A thin layer on a rigid ground, pressed by a plane."""
        thin = draw.uniform(0.02, 0.2)
        cells = [draw.randint(4, 8), draw.randint(4, 8), draw.randint(1, 3)]
        depth = thin*draw.uniform(0.005, 0.03)
        return self._tool(draw, 'PLANe 0 0 0 0 0 -1', (0, 0, 0), depth, cells,
                          ((-.5, -.5, -thin), (.5, .5, 0)))

    def _pressed(self, draw, top_low, top_high, top_cells, ratio, load=None, way=0.0):
        """A block on a larger one, pressed by its upper face."""
        cells = [draw.randint(4, 7), draw.randint(4, 7), draw.randint(2, 4)]
        nu = draw.uniform(0.2, 0.45)
        lines = (['MFEC * * drawn'] + self._material()
                 + self._material(2, self.modulus*ratio, nu)
                 + self._block('under', (-1, -1, -1), (1, 1, 0), cells)
                 + self._block('over', top_low, top_high, top_cells, 2)
                 + self._plane('foot', -1, 'under') + self._plane('lid', 0, 'under')
                 + self._plane('sole', top_low[2], 'over') + self._plane('head', top_high[2], 'over')
                 + ['SURFace track FROM lid IN under', 'SURFace shoe FROM sole IN over',
                    'SURFace crown FROM head IN over', '', 'BOUNdary', '  foot 1 1 1'])
        if load:
            lines += ['  head 1 1 0', '', 'TRACtion', f'  crown 0 0 {-load*self.modulus!r} 1', '']
        else:
            depth = draw.uniform(0.002, 0.01)
            lines += ['  head 1 1 1', '', 'DISPlacement',
                      f'  head 0 0 {self._number(-depth)} 1']
            if way:
                lines += [f'  head {self._number(way*depth)} 0 0 2']
            lines += ['']
        lines += ['PROPortional 1', '  0 0']
        lines += ['  0.5 1', '  1 1', '', 'PROPortional 2', '  0 0', '  0.5 0', '  1 1', ''] if way \
            else ['  1 1', '']
        return lines + self._pair('shoe', 'track', 'foot')

    def _punch(self, draw):
        half, high = draw.uniform(0.2, 0.5), draw.uniform(0.2, 1.0)
        cells = [draw.randint(2, 4), draw.randint(2, 4), draw.randint(1, 4)]
        return self._pressed(draw, (-half, -half, 0), (half, half, high), cells,
                             10**draw.uniform(0.0, 3.0))

    def _blocks(self, draw):
        half, high = draw.uniform(0.3, 0.9), draw.uniform(0.1, 1.0)
        cells = [draw.randint(3, 5), draw.randint(3, 5), draw.randint(1, 4)]
        return self._pressed(draw, (-half, -half, 0), (half, half, high), cells,
                             10**draw.uniform(-1.0, 1.0))

    def _loaded(self, draw):
        half, high = draw.uniform(0.3, 0.9), draw.uniform(0.1, 1.0)
        cells = [draw.randint(3, 5), draw.randint(3, 5), draw.randint(1, 4)]
        return self._pressed(draw, (-half, -half, 0), (half, half, high), cells,
                             10**draw.uniform(-1.0, 1.0), load=draw.uniform(0.001, 0.01))

    def _dragged(self, draw):
        self.steps = 6
        half, high = draw.uniform(0.3, 0.7), draw.uniform(0.2, 1.0)
        cells = [draw.randint(3, 5), draw.randint(3, 5), draw.randint(1, 4)]
        return self._pressed(draw, (-half, -half, 0), (half, half, high), cells,
                             10**draw.uniform(-1.0, 1.0), way=draw.uniform(0.3, 6.0))
