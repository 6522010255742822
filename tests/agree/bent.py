"""Small scenes with curved masters: a shoe on a shaft and in a bore, both elastic, facets that do
not match.

With SMOOth the shape of the master follows from the answer; without it two facets of the shaft may
each hold their own tip. Neither must depend on the solver.
"""
import math

from scene import Deck, Body, Scene, rotate

PRESS, TURN, STEPS = 0.01, 4.0, 6
# name: form, points in a slave facet, last record of the pair, the master is the bore, cells of shoe
# and master around it
BENT = {'shoe on a shaft': ('NTOS', '', 'SMOOth', False, (4, 10)),
        'shoe in a bore': ('GTOS', '', 'SMOOth', True, (3, 8)),
        'shoe in a bore, 6 points': ('GTOS', '6', 'SMOOth', True, (4, 10)),
        'shoe on a shaft, flat facets': ('GTOS', '6', 'SLIP COLLinear', False, (8, 10))}


def sector(inner, outer, half, width, low):
    """Shape of a block as a sector of a ring about the y axis, `half` degrees to each side, from -low
    along the axis."""
    def shape(_, unit):
        radius, angle = inner + (outer - inner)*unit[2], math.radians(half*(2.0*unit[0] - 1.0))
        return [radius*math.sin(angle), width*unit[1] - low, radius*math.cos(angle)]
    return shape


def bent_scene(name):
    """A shoe is pressed against its master and turned along it."""
    form, points, record, bore, (around, below) = BENT[name]
    deck = Deck(name)
    deck.form, deck.points = form, points
    radii = ((0.7, 1.0), (1.0, 1.3)) if bore else ((1.0, 1.3), (0.7, 1.0))
    shoe, ring = [Body(deck, part, cells, (0, 0, 0), (1, 1, 1), deck.elastic(young, 0.3),
                       sector(*ends, half, width, low))
                  for part, cells, young, ends, half, width, low in (
                      ('shoe', (around, 2, 1), 1000.0, radii[0], 20.0, 0.4, 0.0),
                      ('ring', (below, 2, 1), 3000.0, radii[1], 60.0, 0.6, 0.09))]
    near, far = (-1, 0) if bore else (0, -1)
    deck.set('held', shoe.layer(far))
    deck.set('fixed', ring.layer(near))
    deck.surface('sole', shoe.layer(near))
    deck.surface('track', ring.layer(far))
    deck.fix('held')
    deck.fix('fixed')
    way = deck.table([(0, 0), (1, 1)])
    for node in shoe.layer(far):
        x, _, z = deck.x[node - 1]
        grown = 1.0 + (PRESS if bore else -PRESS)/math.hypot(x, z)
        z_end, x_end = rotate(grown*z, grown*x, math.radians(TURN))
        deck.move(node, (x_end - x, 0.0, z_end - z), (way, way, way))
    deck.pair('contact', 'sole', 'track', [
        'PENAlty AUTO 10', 'FRICtion ELLIptic 0.3 0.15',
        'DIREction MATErial CIRCumferential 0 0 0 0 1 0', record])
    deck.outputs = ['held', 'fixed']
    deck.steps(1.0, STEPS)
    return Scene(name, deck, 'bent', mus={'contact': (0.3, 0.15)})
