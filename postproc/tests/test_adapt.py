"""Estimate, sizes, bars, decks and mesh files of mfec-post adapt, without meshers."""
import argparse
import itertools

import numpy as np
import pytest
from mfec import Deck
from mfec_post import adapt, adapt_deck, adapt_estimate, adapt_model, adapt_remesh

DECK = '''MFEC * * two blocks
MATErial 1 upper
  ELAStic ISOTropic 10 0.3

MATErial 2
  ELAStic ISOTropic 10 0.3

SET sole
  PLANe 3 0

CONTact
  PAIR 1 c
    NTOS sole track
    SMOOth
  PAIR 2 d
    GTOS 'other' track 3

OUTPut
  FIELds NONE
  POINts c

END
BATCh
  DT,,1
  STEP,,1
END
'''


def blocks(n=3, order=1):
    """A cube of n cells a side, each cut into six."""
    axis = np.arange(n + 1) / n
    points = np.stack(np.meshgrid(axis, axis, axis, indexing='ij'), -1).reshape(-1, 3)
    i, j, k = (a.ravel() for a in np.meshgrid(*[np.arange(n)] * 3, indexing='ij'))
    m = n + 1
    corner = {(a, b, c): (i + a) * m * m + (j + b) * m + k + c
              for a, b, c in itertools.product((0, 1), repeat=3)}
    steps = np.eye(3, dtype=int)
    way = [[(0, 0, 0), tuple(steps[a]), tuple(steps[a] + steps[b])]
           for a, b in itertools.permutations(range(3), 2)]
    cells = np.concatenate([np.stack([corner[x] for x in (*path, (1, 1, 1))], 1) for path in way])
    p, q, r, s = (points[cells[:, k]] for k in range(4))
    left = np.einsum('ij,ij->i', q - p, np.cross(r - p, s - p)) < 0
    cells[left] = cells[left][:, [1, 0, 2, 3]]
    one = np.ones(len(cells), int)
    top = np.flatnonzero(points[:, 2] > 1 - 1e-9)
    corners = adapt_model.facets_of(cells)[0]
    bodies = adapt_model.Bodies(points, cells, one, one, ['cube'], {'top': top},
                                {'lid': corners[np.isin(corners, top).all(1)]},
                                {1: adapt_model.Material(1, 10.0, 0.3, False, False)})
    return adapt_model.raised(bodies) if order == 2 else bodies


def adaptation(tell=print):
    """Of a deck that is not read."""
    return adapt.Adaptation(argparse.Namespace(deck='x.inp', goal=['top.R1'], error='1%', geo=None, order=2,
                                               set=[], time=1.0, out=None), tell)


def test_the_mass_matrices_are_those_of_the_shape_functions():
    """Their sum is the volume; the corner of ten nodes has 6 V/420."""
    assert adapt_estimate.mass(1).sum() == pytest.approx(1)
    assert adapt_estimate.mass(2).sum() == pytest.approx(1)
    assert adapt_estimate.mass(2)[0, 0] == pytest.approx(1 / 70)


def test_linear_stresses_of_ten_nodes_have_no_error():
    """And those of four nodes one of the second order."""
    shares = []
    for bodies in (blocks(2, 2), blocks(3, 1), blocks(6, 1)):
        x = bodies.points
        u = np.stack([x[:, 0] ** 2, x[:, 0] * x[:, 1], x[:, 2]], 1)
        eta, energy = adapt_estimate.estimate(bodies, u[None])
        shares.append(eta.sum() / energy[0])
    assert shares[0] < 1e-6
    assert shares[1] / shares[2] == pytest.approx(4, rel=0.15)


def test_the_estimate_is_the_error_of_a_known_field():
    """u = x^2 e_x interpolated by four nodes: the estimate is near the true error of its stresses."""
    bodies = blocks(6, 1)
    x = bodies.points
    u = np.stack([x[:, 0] ** 2, 0 * x[:, 0], 0 * x[:, 0]], 1)
    eta, _ = adapt_estimate.estimate(bodies, u[None])
    c = adapt_estimate.elasticity(10.0, 0.3)[0, 0]
    # strain 2 x against the element's (x1^2 - x0^2)/(x1 - x0) = x0 + x1: variance about the middle,
    # 4 h^2/80 + 4 (difference of the centroid from the middle)^2
    place = x[bodies.cells].mean(1)[:, 0]
    middle = x[bodies.cells][:, :, 0].min(1) + 1 / 12
    variance = np.var(x[bodies.cells][:, :, 0], axis=1) / 5
    true = (c * bodies.volumes * 4 * (variance + (place - middle) ** 2)).sum()
    assert eta.sum() == pytest.approx(true, rel=0.15)


def test_sizes_make_as_many_cells_as_asked_for():
    """Where the error is even they all shrink alike; where it is in one cell that one shrinks most."""
    bodies = blocks(4)
    even = adapt_remesh.wanted_sizes(bodies, bodies.volumes, 3.0)
    assert even == pytest.approx(np.cbrt(1 / 3) * bodies.sizes[0], rel=1e-4)
    single = np.full(len(bodies.cells), 1e-9)
    single[0] = 1.0
    h = adapt_remesh.wanted_sizes(bodies, single, 3.0)
    assert h.argmin() in bodies.cells[0]
    edge = np.linalg.norm(bodies.points[1] - bodies.points[0])
    assert h.max() - h.min() <= adapt_remesh.GRADIENT * np.sqrt(3) * 4 * edge + 1e-9


def test_the_bar_is_the_largest_of_three():
    """doc/theory, eq. (13.13)."""
    last = adapt.Loop(0, 10, 1, 1, [0.04], None, [1.0], [1.0])
    loop = adapt.Loop(1, 30, 1, 1, [0.02], None, [1.1], [1.1])
    assert adapt.mesh_bar(loop, 0.0, last, 0) == pytest.approx(1.5 * 0.02 * 1.1)
    assert adapt.mesh_bar(loop, 0.1, last, 0) == pytest.approx(1.5 * 0.1 * 0.5 / 0.5)
    last.mesh = [0.5]
    assert adapt.mesh_bar(loop, 0.0, last, 0) == pytest.approx(0.25)


def test_the_bar_of_the_penalty():
    """Springs in series, 1/Q = 1 + x: the value without the penalty's share lies within its bar of 1; where
    points stick all of the share counts."""
    for x in (0.003, 0.01, 0.03):
        stiff, soft = 1 / (1 + x), 1 / (1 + 4 * x)
        share = (stiff - soft) / 3
        bar = adapt.penalty_bar(share, stiff + share, False)
        assert abs(stiff + share - 1) < bar < 0.25 * share
        assert adapt.penalty_bar(share, stiff + share, True) == share


def test_a_deck_gets_facets_of_six_nodes():
    """What is changed is said; the user's deck stays."""
    deck = Deck(DECK)
    made, notes = adapt_deck.prepare(deck, {'track', 'other'}, 2, True)
    assert deck.text == DECK
    assert [r.items for r in made.records('GTOS')] == [('GTOS', 'adapt_slave_1', 'track', '6'),
                                                       ('GTOS', "'other'", 'track', '6')]
    assert next(made.records('SURF')).items == ('SURFace', 'adapt_slave_1', 'FROM', 'sole')
    assert [r.items[2] for r in made.records('MATE')] == ['adapt_material_1', 'adapt_material_2']
    assert not list(made.records('SMOO')) and not list(made.records('POIN'))
    assert [r.items for r in made.records('FIEL')] == [('FIELds', 'displacement', 'contact')]
    assert len(notes) == 2 and 'NTOS sole track' in notes[0]
    assert adapt_deck.own_names(made) == {'sole', 'adapt_slave_1'}
    assert list(adapt_deck.prepare(deck, {'track'}, 1, False)[0].records('NTOS'))


@pytest.mark.parametrize('text', ['root', 'root.', 'a.R1/b.R1/c.R1', 'root R1'])
def test_a_goal_that_is_none_is_named(text):
    """With what goals look like."""
    with pytest.raises(adapt_deck.GoalError, match='goal|quotient'):
        adapt_deck.Goal(text)


@pytest.mark.parametrize('text, wish', [('1%', 0.01), ('0.02', 0.02)])
def test_the_wish(text, wish):
    """A share or per cent."""
    assert adapt.wish_of(text) == pytest.approx(wish)


@pytest.mark.parametrize('text', ['0', '-1%', 'much', '200%'])
def test_a_wish_that_is_none(text):
    """It must be between 0 and 1."""
    with pytest.raises(adapt_deck.GoalError, match='1%'):
        adapt.wish_of(text)


@pytest.mark.parametrize('order', [1, 2])
def test_a_mesh_file_has_its_parts(tmp_path, order):
    """Own parts of the deck are left to it; the rest is written with its sides."""
    bodies = blocks(2, order)
    adapt_model.write_mesh(bodies, tmp_path / 'x.inp', {'top'}, 'adapt_material_')
    text = (tmp_path / 'x.inp').read_text(encoding='utf-8')
    assert f'*ELEMENT, TYPE=C3D{10 if order == 2 else 4}, ELSET=cube' in text
    assert 'MATERIAL=adapt_material_1' in text and '*NSET' not in text
    sides = text.split('*SURFACE, NAME=lid, TYPE=ELEMENT\n')[1].split('\n')[:8]
    for side in sides:
        cell, face = side.split(', S')
        nodes = bodies.cells[int(cell) - 1][adapt_model.FACES[int(face) - 1]]
        assert (bodies.points[nodes][:, 2] > 1 - 1e-9).all()


def test_medit_files_come_back(tmp_path):
    """As mmg gets and gives them."""
    bodies = blocks(2)
    corners = adapt_model.facets_of(bodies.cells)[0]
    mask = np.arange(len(corners)) % 3
    group = np.arange(len(bodies.cells)) % 2
    adapt_remesh.write_medit(tmp_path / 'x.mesh', bodies.points, bodies.cells, group, corners, mask)
    points, cells, groups, facets, masks = adapt_remesh.read_medit(tmp_path / 'x.mesh')
    assert points == pytest.approx(bodies.points)
    assert (np.sort(cells) == np.sort(bodies.cells)).all() and (groups == group).all()
    assert (facets == corners).all() and (masks == mask).all()


def test_bodies_are_told_apart():
    """Two cubes that touch in no node."""
    one = blocks(2)
    n = len(one.points)
    both = adapt_model.Bodies(np.vstack([one.points, one.points + 2]), np.vstack([one.cells, one.cells + n]),
                              np.ones(96, int), np.ones(96, int), ['cubes'], {}, {}, one.materials)
    assert [len(piece) for piece in both.pieces()] == [48, 48]


def test_facets_of_round_surfaces_sag():
    """Facets bent by an angle along an edge: angle times length over eight; sharp edges do not count."""
    bodies = blocks(1)
    bodies.surfaces['all'] = adapt_model.facets_of(bodies.cells)[0]
    assert adapt.sag_of(bodies, {'all'}) == pytest.approx(0, abs=1e-9)
    flat = bodies.points[:, 2] > 0.5
    bodies.points[flat & (bodies.points[:, 0] > 0.5) & (bodies.points[:, 1] > 0.5), 2] += 0.1
    assert 0.005 < adapt.sag_of(bodies, {'all'}) < 0.05


class Pressed:
    """Results with one pair: slave points in a square of n x n facets, those with x < a in contact."""

    def __init__(self, n, a):
        self.pairs, i = ['c'], np.arange(n)
        self.points = np.stack(np.meshgrid(i, i, [0.0], indexing='ij'), -1).reshape(-1, 3) / n
        self.node_numbers = np.arange(1, n * n + 1)
        self.touching = self.points[:, 0] < a

    def contact(self, pair):
        """A point a node, of the same area each."""
        n = len(self.points)
        return {'status': self.touching.astype(int), 'area': np.full(n, 1.0 / n),
                'node': self.node_numbers[:, None], 'weight': np.ones((n, 1))}


def test_facets_count_across_a_rim_alone():
    """A strip of contact has as many facets as its width; none count where the surface ends with it."""
    wide, narrow, whole = (adapt.across_contact(some, {'c': some.contact('c')})
                           for some in (Pressed(20, a) for a in (0.6, 0.1, 2.0)))
    assert wide == pytest.approx(12 * np.sqrt(np.sqrt(3) / 4), rel=0.02)
    assert narrow < adapt.ENOUGH_FACETS < wide
    assert whole is None


def test_few_facets_give_no_bar():
    """And no companion runs; the mesh is refined first, and the line says why."""
    said = []
    work = adaptation(said.append)
    work.companions = lambda *rest: pytest.fail('a companion')
    work.write_files = lambda: None
    last, loop = (adapt.Loop(k, 10, 1, 1, [1e-4], 2.5, [1.0], [1.0]) for k in (0, 1))
    work.judge(loop, last, [1.0], None, True)
    work.keep(loop)
    assert loop.bar(0) is None and work.factor(loop) == adapt.LEAST_GROWTH
    loop.across = 1.5
    assert work.factor(loop) == pytest.approx(1.25 * adapt.ENOUGH_FACETS / 1.5)
    assert '2.5 facets across the contact: too few for a bar' in said[0] and 'no bar yet' in said[1]


@pytest.mark.parametrize('material, said', [
    ((1, 10.0, 0.3, True, False), 'finite strain'),
    ((1, 10.0, 0.49, False, False), 'nearly incompressible'),
    ((1, 10.0, 0.3, False, True), 'rigid regions')])
def test_limits_are_told(material, said):
    """What no number of the tool knows of."""
    work = adaptation()
    bodies = blocks(1)
    work.tell_limits(bodies)
    assert work.notes == []
    bodies.materials = {1: adapt_model.Material(*material)}
    work.tell_limits(bodies)
    assert len(work.notes) == 1 and work.notes[0].startswith(said)


def test_the_sag_is_told():
    """Without a geometry, of the surfaces of pairs, where it is a share of the way."""
    work = adaptation()
    work.pairs = list(Deck('CONTact\n  PAIR 1 c\n    GTOS lid lid\n').records('GTOS'))
    bodies = blocks(2)
    results = argparse.Namespace(points=bodies.points, node_numbers=np.arange(len(bodies.points)))
    work.judge_sag(results, {}, bodies, np.full((1, len(bodies.points), 3), 0.1))
    assert work.notes == [] and not work.sags
    bodies.points[:, 2] -= 0.1 * ((bodies.points[:, :2] - 0.5) ** 2).sum(1)
    work.judge_sag(results, {}, bodies, np.full((1, len(bodies.points), 3), 0.1))
    assert work.sags
    assert len(work.notes) == 1
    assert work.notes[0].startswith('facets of round contact surfaces sag by up to 0.0')


def test_the_slave_is_no_coarser_than_its_master():
    """At the contact alone: elsewhere sizes are as they were."""
    bodies = blocks(4)
    h = np.full(len(bodies.points), 0.3)
    corners = adapt_model.facets_of(bodies.cells)[0]
    floor = np.flatnonzero(bodies.points[:, 2] < 1e-9)
    bodies.surfaces['floor'] = corners[np.isin(corners, floor).all(1)]
    assert adapt_remesh.matched(bodies, h, [('lid', 'floor')]) == pytest.approx(h)
    h[bodies.sets['top'][0]] = 0.05
    bodies.surfaces['half'] = bodies.surfaces['lid'][::2]
    finer = adapt_remesh.matched(bodies, h, [('half', 'lid')])
    near = np.unique(bodies.surfaces['half'])
    assert finer[near].min() == 0.05 and finer[floor] == pytest.approx(0.3)


@pytest.mark.parametrize('bend', [0.1, -0.1])
def test_the_mean_sag_is_that_of_a_paraboloid(bend):
    """z = -k (x^2 + y^2)/2 lies k h^2/6 above halves of squares with sides h in the mean; hollow: below."""
    bodies = blocks(8)
    bodies.points[:, 2] -= bend / 2 * ((bodies.points[:, :2] - 0.5) ** 2).sum(1)
    sag = adapt.mean_sag(bodies, 'lid', np.array([[0.5, 0.5, 1.0]]))
    assert sag == pytest.approx(bend / 64 / 6, rel=0.01)


def test_a_sag_counts_as_a_penetration_does():
    """Over the mean gap of what is closed."""
    bodies = blocks(4)
    bodies.points[:, 2] -= 0.05 * ((bodies.points[:, :2] - 0.5) ** 2).sum(1)
    top = bodies.sets['top']
    n = len(top)
    points = {'status': np.ones(n, int), 'area': np.full(n, 0.04), 'gap': np.full(n, -1e-3),
              'node': top[:, None] + 1, 'weight': np.ones((n, 1))}
    points['status'][0], points['gap'][0] = 0, 1.0
    results = argparse.Namespace(points=bodies.points, node_numbers=np.arange(1, len(bodies.points) + 1))
    sags = {'c': lambda x: [adapt.mean_sag(bodies, 'lid', x)]}
    ratio = adapt.sag_over_penetration(results, {'c': points}, sags)
    assert ratio == pytest.approx(0.1 / 16 / 6 / 1e-3, rel=0.05)


def test_what_comes_late_has_an_error_of_its_own():
    """doc/theory, eq. (13.11): a force that is nothing at the time before has that of the change alone."""
    errors = np.array([0.03, 0.02, 0.01, 0.08])
    assert adapt.relative_errors(errors[2:3], [2.0], None) == [0.01]
    assert adapt.relative_errors(errors, [2.0], (0, [0.0])) == [0.08]
    assert adapt.relative_errors(errors, [2.0], (1, [1.0])) == pytest.approx([0.05])


def test_the_finer_companion_is_reported():
    """And the next loop compares with what its own increments give."""
    work = adaptation()
    loop = adapt.Loop(1, 10, 1, 1, [0.02], None, [1.0], [1.0], mesh=[0.002], penalty=[0.0], finer=[0.003])
    work.become_finer(loop)
    assert loop.values == [1.003] and loop.steps == [0.003] and loop.increments == 2
    assert work.mend(loop)[0] == [1.003] and work.increments == 2
    loop.mesh, work.increments = [0.02], 1
    before, remesh = work.mend(loop)
    assert before == pytest.approx([1.0], abs=1e-12) and remesh and work.increments == 1


@pytest.mark.parametrize('order', [1, 2])
def test_patches_are_the_elements_around_a_node(order):
    """Two rings where one has too few; each element once."""
    corners = blocks(2).cells
    n = corners.max() + 1
    around, size = adapt_estimate.patches(corners, n, order)
    for node, found in enumerate(np.split(around, np.cumsum(size)[:-1])):
        ring = np.flatnonzero((corners == node).any(1))
        if len(ring) < adapt_estimate.FEWEST[order]:
            ring = np.flatnonzero(np.isin(corners, corners[ring]).any(1))
        assert (found == ring).all()


def test_companions_wait_for_the_mesh():
    """They run where the mesh alone is within the wish, or in the last loop."""
    work = adaptation()
    last = adapt.Loop(0, 10, 1, 1, [0.04], None, [1.0], [1.0])
    for error, late, runs in ((0.02, False, 0), (0.02, True, 1), (0.002, False, 1)):
        asked, loop = [], adapt.Loop(1, 30, 1, 1, [error], None, [1.0], [1.0])
        work.companions = lambda *rest, asked=asked: asked.append(rest)
        work.judge(loop, last, [1.0], None, True, late)
        assert len(asked) == runs and loop.mesh == pytest.approx([1.5 * error])


def test_sags_of_both_sides_take_each_other_away():
    """Facets of a shaft and of its bore, one on the other, normals either way; what is far does not count."""
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    up = np.array([[0.0, 0.0, 1.0]] * 2)
    area = np.full(2, 0.1)
    shaft = adapt_remesh.Sag(places, area, up, np.array([3e-6, 5e-6]))
    bore = adapt_remesh.Sag(places + 1e-3, area, -up, np.array([-1e-6, -1e-6]))
    assert adapt.bent_sag([shaft], places) == pytest.approx(4e-6)
    assert adapt.bent_sag([shaft, bore], places) == pytest.approx(3e-6)
    far = adapt_remesh.Sag(places + 9, area, up, area)
    assert adapt.bent_sag([far, shaft], places) == pytest.approx(4e-6)
    assert adapt.bent_sag([], places) == 0
