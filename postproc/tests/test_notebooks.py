"""The notebooks run from their first cell to the last, and find what they say."""
import json
import os

import matplotlib
import numpy as np
import pytest

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'notebooks')
NAMES = sorted(name for name in os.listdir(FOLDER) if name.endswith('.ipynb'))


def cells(name):
    """The cells of a notebook."""
    with open(os.path.join(FOLDER, name), encoding='utf-8') as stream:
        return json.load(stream)['cells']


def perform(name, folder, monkeypatch):
    """Runs all cells of code in one name space, as a kernel does; the names that they leave."""
    monkeypatch.chdir(folder)
    matplotlib.use('Agg')
    names = {'__name__': '__main__'}
    for number, cell in enumerate(cells(name), 1):
        if cell['cell_type'] == 'code':
            exec(compile(''.join(cell['source']), f'{name}, cell {number}', 'exec'), names)
    matplotlib.pyplot.close('all')
    return names


def test_first_contact(tmp_path, monkeypatch, capsys):
    """Friction is that of the deck and of each variant; the mistake gets its remedy."""
    names = perform('first_contact.ipynb', tmp_path, monkeypatch)
    mu = float(names['deck']['mu'])
    assert names['contact']['mobilised'].iloc[-1] == pytest.approx(mu, rel=1e-6)
    assert names['table']['T/N'].to_numpy(float) == pytest.approx([0.1, 0.2, 0.3, 0.4], rel=0.01)
    said = capsys.readouterr().out
    assert "did you mean 'mu'?" in said and '100%  step 8 of 8' in said


def test_identification(tmp_path, monkeypatch):
    """The truth lies within four deviations, and chi2 is that of noise: 2 n - 3, its deviation the root of
    twice that."""
    names = perform('identification.ipynb', tmp_path, monkeypatch)
    truth = np.array(list(names['truth'].values()))
    assert np.all(abs(names['found'] - truth) < 4.0 * names['deviation'])
    assert np.all(names['deviation'] < [0.01, 0.01, 2.0])
    chi2, free = names['residual'] @ names['residual'], names['residual'].size - 3
    assert abs(chi2 - free) < 4.0 * np.sqrt(2.0 * free) and names['k'] < 7


@pytest.mark.parametrize('name', NAMES)
def test_nothing_is_left_of_a_run(name):
    """Outputs and counts are not kept: they would grow old."""
    assert len(cells(name)) > 5
    for cell in cells(name):
        assert not cell.get('outputs') and cell.get('execution_count') is None
