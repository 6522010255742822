"""Identification without the program: steady drag, canonical form, estimates, the start."""
import argparse
import os

import numpy as np
import pytest
from mfec_post import identify as tool

CIRCLE = np.stack([np.cos(np.arange(24) * np.pi / 12), np.sin(np.arange(24) * np.pi / 12)], 1)


def test_drag_has_the_numbers_of_the_theory():
    """doc/theory: 45 degrees to the lay, mu 0.1 and 0.08."""
    way = np.array([[np.sqrt(.5), np.sqrt(.5)]])
    along, across = way[0], np.array([-way[0, 1], way[0, 0]])
    for m, wanted in ((0, (.088345221, 0.)), (2, (.090553851, -.019877675))):
        force = tool.drag(.1, .08, 0., m, way)[0]
        assert force @ along == pytest.approx(wanted[0], abs=1e-9)
        assert force @ across == pytest.approx(wanted[1], abs=1e-9)


@pytest.mark.parametrize('rule', [0, 1, 2])
def test_the_start_finds_steady_drag(rule):
    """Exact ratios, but for a fifth of the points that are no steady drag."""
    ratio = tool.drag(.3, .2, .5, rule, CIRCLE)
    ratio[::5] *= .7
    found, m = tool.fit_drag(CIRCLE, ratio)
    assert m == rule
    mu1, mu2, angle = tool.canonical(*found[:2], np.degrees(found[2]))
    assert (mu1, mu2) == pytest.approx((.3, .2), rel=.02)
    assert angle == pytest.approx(np.degrees(.5), abs=1.)


def test_the_same_law_has_one_form():
    """mu1 >= mu2, angle in (-90, 90]."""
    assert tool.canonical(.2, .3, 10.) == pytest.approx((.3, .2, -80.))
    assert tool.canonical(.3, .2, -90.) == pytest.approx((.3, .2, 90.))


def test_what_is_not_determined_is_named():
    """A column that is a multiple of another one, and one that is zero."""
    j = np.random.default_rng(1).standard_normal((20, 3))
    assert tool.Estimate(['a', 'b', 'c'], j).determined
    j[:, 1] = -2. * j[:, 0] + 1e-9 * j[:, 1]
    estimate = tool.Estimate(['a', 'b', 'c'], j)
    assert not estimate.determined
    assert 'a' in estimate.combination() and 'b' in estimate.combination()
    assert ' c' not in estimate.combination()
    j[:, 1] = 0.
    assert 'b: nothing' in tool.Estimate(['a', 'b', 'c'], j).combination()


def test_deviations_are_those_of_the_data():
    """sd of a straight line through 50 points."""
    x = np.linspace(0., 1., 50)
    estimate = tool.Estimate(['a', 'b'], np.stack([x, np.ones(50)], 1) / .1)
    assert estimate.sd[0] == pytest.approx(.1 / np.sqrt(np.sum((x - x.mean())**2)))


def test_bad_input_is_told(tmp_path, capsys):
    """Exit code 2 and a line that says what is wrong."""
    deck = tmp_path / 'x.inp'
    deck.write_text('MFEC * * x\nPARAmeter\n  m1 = 0.1\n')
    given = argparse.Namespace(deck=str(deck), data=None, columns=None, set_name='top', fit='m1',
                               sigma='1%', sigma_column=None, bounds=[], nuisance='', level=95.,
                               plan=False, refits=False, start='drag', program='true', out='x.png')
    assert tool.main(given) == 2
    assert '--data' in capsys.readouterr().err
    given.plan, given.fit = True, 'm7'
    assert tool.main(given) == 2
    assert 'm7' in capsys.readouterr().err
    given.deck = os.path.join(str(tmp_path), 'no.inp')
    assert tool.main(given) == 2
