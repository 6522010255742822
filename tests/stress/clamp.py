"""Random scenes with a plate that a stamp presses on a floor, beside blocks on a base of their own: the
forces of these must not hide that the plate is thrown out. Floor and stamp have friction, so that
the plate's place is told, and the stamp stays over the plate: at no end time may it lose its force."""
import math
import random

from chance import Maker

# The stamp goes no farther aside than this share of the scene's unit: it stays over the plate.
MOST_ASIDE = 0.35
# A force that is less than this share of the largest is lost.
LOST = 1e-3


class Clamp(Maker):
    """A random scene that has a plate and a stamp in any case."""

    # The plate is always there (0.15); no block is under a dead load (0.25: it may tip, by more than
    # small strain bears), and no pair is turned (0.2: a coarse slave over a small master has points
    # beside it, and nothing is pressed).
    SURE = {0.15: True, 0.25: False, 0.2: False}

    def chance(self, share):
        """As drawn, but for what is sure."""
        drawn = super().chance(share)
        return self.SURE.get(share, drawn)

    def rub(self):
        """Pairs of the plate without friction get some."""
        for name, _, _, lines in self.deck.pairs:
            if name in ('lower', 'upper') and 'FRICtion NONE' in lines:
                mu = 10.0**self.draw.uniform(-1.3, 0.0)
                lines[lines.index('FRICtion NONE')] = f'FRICtion COULomb {mu!r}'
                self.mus[name] = (mu, mu)

    def aside(self):
        """How far the stamp goes aside, over the scene's unit."""
        stamp = next(body for body in self.deck.bodies if body.name == 'stamp')
        node = stamp.layer(-1)[0]
        tables = next(tables for n, tables in self.deck.numbers if n == node)
        ways = [[p for _, p in self.deck.tables[t - 1]] for t in tables[:2]]
        return max(math.hypot(x, y) for x, y in zip(*ways))/self.scale


def judge(outcome):
    """How much of its force a pair of the plate has lost where it has least: below the share that
    counts as lost it is all of it."""
    worst = 0.0
    for name in ('lower', 'upper'):
        forces = [values[3] for _, values in outcome.rows('con', name)]
        if min(forces) < LOST*max(forces):
            worst = 1.0
    return worst


def clamped_scene(seed):
    """The scene of one seed."""
    k = 0
    while True:
        maker = Clamp(f'clamp {seed} {k}')
        scene = maker.scene()
        if maker.aside() <= MOST_ASIDE:
            break
        k += 1
    maker.rub()
    draw = random.Random(f'clamp {seed}')
    maker.deck.form = 'GTOS'
    maker.deck.points = draw.choice(('', '', '6', '7', 'SEGMent'))
    scene.name, scene.group = f'clamp {seed}', 'clamp'
    scene.judge, scene.wanted = judge, 0.5
    scene.notes += ', ' + (maker.deck.points or '3') + ' points'
    return scene
