"""The package mfec: runs of the program, their results, and what goes wrong."""
import gc
import os

import mfec
import numpy as np
import pytest

BLOCK = mfec.example('manual/block_on_plate')


@pytest.fixture(scope='module')
def block():
    """One run, its progress beside it."""
    heard = []
    result = mfec.run(BLOCK, set={'mu': 0.25}, progress=heard.append)
    return result, heard


def test_tables(block):
    """Pandas tables have the rows of the files; friction tends to mu."""
    result, _ = block
    assert list(result.contact['step']) == list(range(1, 9))
    last = result.contact.iloc[-1]
    assert last['Ft'] / last['Fn'] == pytest.approx(0.25, rel=1e-6)
    top = result.reactions[result.reactions['set'] == 'top'].iloc[-1]  # the block is in balance
    assert np.allclose([top[f'R{i}'] + last[f'F{i}'] for i in (1, 2, 3)], 0.0, atol=1e-8)
    assert len(result.iterations) == result.steps['solves'].sum()
    assert result.steps['time'].iloc[-1] == 2.0
    assert result.costs.set_index('name').loc['dense factorisation', 'count'] > 0
    assert result.seconds > 0.0


def test_fields(block):
    """Numpy fields have the shape of the mesh, and balance with the tables."""
    result, _ = block
    u = result.field('displacement')
    assert u.shape == result.points.shape == (51, 3)
    assert len(result.field('stress')) == len(result.cells)
    surface = result.surface('sliding')
    force = result.contact[['F1', 'F2', 'F3']].iloc[-1].to_numpy(float)
    assert np.allclose(surface.facet_integral('traction'), force, rtol=1e-6)
    assert {'displacement', 'stress'} <= set(result.fields())
    assert (result.field('von_mises') >= 0.0).all()  # from the stress where the file does not hold it
    with pytest.raises(KeyError, match='displacement.*stress'):
        result.field('temperature')
    with pytest.raises(KeyError, match='slave, master'):
        result.surface('sliding', 'upper')


def test_audit(block):
    """The audit is a table of all checks at all output times."""
    result, _ = block
    assert set(result.audit['step']) == set(range(1, 9))
    balance = result.audit[result.audit['check'] == 'balance']
    assert (balance['verdict'] == 'ok').all() and (balance['value'] < 1e-9).all()
    assert result.verdict in ('ok', 'warning')
    assert (len(result.warnings) > 0) == (result.audit['verdict'] == 'warning').any()


def test_progress(block):
    """Each solve and each output time is told, and the share of what is done grows to 1."""
    result, heard = block
    assert len(heard) == len(result.iterations) + 8
    shares = [p.done for p in heard]
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert str(heard[-1]).startswith('step 8 of 8, time 2')


def test_progress_may_stop_a_run(tmp_path):
    """What the callback raises comes through, and the program has ended."""
    def stop(progress):
        if progress.event == 'end_time' and progress.step == 2:
            raise RuntimeError('enough')
    with pytest.raises(RuntimeError, match='enough'):
        mfec.run(mfec.example('sliding_cube'), out=tmp_path, progress=stop)
    assert len(mfec.Result(tmp_path / 'sliding_cube').reactions) >= 4


def test_files_go_with_the_result():
    """Without `out` the files lie in a folder that goes when nobody has the result any more."""
    result = mfec.run(mfec.example('manual/pulled_block'))
    folder = result.base.parent
    assert result.path('.rea').exists() and '.vtkhdf' in result.files
    del result
    gc.collect()
    assert not folder.exists()


def test_result_of_before(tmp_path):
    """Files of an earlier run are read without its records."""
    mfec.run(mfec.example('manual/pulled_block'), out=tmp_path)
    result = mfec.Result(tmp_path / 'pulled_block.vtkhdf')
    top = result.reactions[result.reactions['set'] == 'top']
    assert top['R3'].iloc[-1] == pytest.approx(10.0)
    assert result.audit.empty and result.verdict == '' and 'mfec' in result.log
    with pytest.raises(FileNotFoundError, match='.rea'):
        result.table('.rig')
    with pytest.raises(FileNotFoundError, match='none at all'):
        mfec.Result(tmp_path / 'pulled_blocks').reactions  # noqa: B018


def test_errors_of_a_deck():
    """They arrive with file, line, column, text and remedy."""
    deck = mfec.Deck.read(BLOCK)
    wrong = deck.text.replace('COULomb mu', 'COULomb muh')
    with pytest.raises(mfec.DeckError) as caught:
        mfec.run(mfec.Deck(wrong, BLOCK))
    error = caught.value
    line = next(k for k, text in enumerate(wrong.split('\n'), 1) if 'muh' in text)
    problem = error.problems[0]
    assert (problem.line, problem.column) == (line, wrong.split('\n')[line - 1].index('muh') + 1)
    assert problem.file == 'block_on_plate.inp' and 'muh' in problem.text  # its folder has gone
    assert str(error).startswith(f'block_on_plate.inp:{line}:')
    assert problem.remedy == "did you mean 'mu'?" == error.remedy
    assert error.code == 1 and error.result is None and 'undefined parameter' in str(error)


def test_errors_of_arguments():
    """An unknown parameter has no place; an unknown file says so."""
    with pytest.raises(mfec.DeckError, match="did you mean 'mu'") as caught:
        mfec.run(BLOCK, set={'muh': 1})
    assert caught.value.problems[0].file == 'command line'
    with pytest.raises(mfec.DeckError, match='no such file'):
        mfec.run('nowhere.inp')
    for wrong in (None, True, [1]):
        with pytest.raises(TypeError, match='neither a number'):
            mfec.run(BLOCK, set={'mu': wrong})
    with pytest.raises(mfec.ResourceError):
        mfec.run(BLOCK, out='/dev/null/x')
    with pytest.raises(FileNotFoundError, match='no program'):
        mfec.run(BLOCK, program='no_such_mfec')


def test_no_convergence():
    """The exception has the message, what to do, and what is on disk."""
    deck = os.path.join(os.path.dirname(BLOCK), '..', '..', 'tests', 'properties', 'decks',
                        'gliding_block.inp')
    with pytest.raises(mfec.ConvergenceError) as caught:
        mfec.run(deck)
    error = caught.value
    assert error.code == 2 and error.remedy and error.problems == []
    assert error.result is not None and error.result.of('costs')


def test_broken_program(tmp_path):
    """A program that is killed is a StoppedError; half a record is no record."""
    program = tmp_path / 'mfec'
    program.write_text('#!/bin/sh\necho \'{"event":"warning","text":"x"}\'\necho \'{"eve\'\nkill -9 $$\n')
    program.chmod(0o755)
    with pytest.raises(mfec.StoppedError, match='exit code -9'):
        mfec.run(BLOCK, program=str(program))


def test_check(tmp_path):
    """--check as a list of lines; what is to be looked at is there, if it is named."""
    lines = mfec.check(BLOCK)
    assert lines[0].startswith('no errors in the deck: 51 nodes')
    assert not any('looked at' in line for line in lines)
    lines = mfec.check(BLOCK, out=tmp_path)
    assert 'looked at' in lines[-1] and (tmp_path / 'block_on_plate.check.vtkhdf').exists()


def test_restart_and_derivatives(tmp_path):
    """A run goes on from a state; derivatives by a parameter are those of differences."""
    whole = mfec.run(BLOCK, out=tmp_path / 'a')
    on = mfec.run(BLOCK, out=tmp_path / 'b', restart=whole.path('.vtkhdf'), step=6)
    assert np.array_equal(on.reactions[['R1', 'R2', 'R3']].tail(2),
                          whole.reactions[['R1', 'R2', 'R3']].tail(2))
    slopes = mfec.run(BLOCK, sens='mu').sensitivities
    slope = slopes[(slopes['quantity'] == 'sliding') & (slopes['step'] == 8)]['d1'].iloc[0]
    value = float(mfec.Deck.read(BLOCK)['mu'])
    low, high = (mfec.run(BLOCK, set={'mu': value + d}).contact['F1'].iloc[-1] for d in (-1e-4, 1e-4))
    assert slope == pytest.approx((high - low) / 2e-4, rel=1e-4)


def test_study():
    """A row for each variant; each is what a run of its own gives."""
    table = mfec.study(BLOCK, {'mu': [0.1, np.float64(0.2)]}, set={'mu': 0.3})
    assert list(table['mu']) == [0.1, 0.2] and list(table['exit']) == [0, 0]
    assert [table[name].dtype.kind for name in ('step', 'exit', 'mu')] == ['i', 'i', 'f']
    alone = mfec.run(BLOCK, set={'mu': 0.2}).reactions
    name = next(column for column in table if column.startswith('R1:'))
    mine = alone[(alone['set'] == name[3:])]['R1'].iloc[-1]
    assert table[name].iloc[1] == pytest.approx(mine, rel=1e-6)
    assert table.attrs['result'].contact['Fn'].iloc[-1] > 0


def test_version():
    """The package and the program are of one version."""
    assert mfec.program_version() == mfec.__version__


def test_examples(tmp_path):
    """Examples have names, can be copied, and unknown ones say which there are."""
    assert 'sliding_cube' in mfec.examples() and 'gallery/lug' in mfec.examples()
    copy = mfec.copy_examples(tmp_path / 'x')
    assert (copy / 'gallery' / 'lug.msh').exists()
    with pytest.raises(FileNotFoundError, match='sliding_cube'):
        mfec.example('sliding_cub')
