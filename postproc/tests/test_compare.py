"""The comparison of tables."""
import pytest
from mfec_post.compare import main

HEAD = '# x\n#   step  time  set  R1  R2\n'
OLD = HEAD + '1 0.5 top 1.0 0.0\n2 1.0 top 100.0 0.0\n'


@pytest.fixture
def compare(tmp_path, capsys):
    """Compares two texts; the exit code and what was printed."""
    def call(old, new, *options):
        for name, text in (('old.rea', old), ('new.rea', new)):
            (tmp_path / name).write_text(text)
        status = main([str(tmp_path / 'old.rea'), str(tmp_path / 'new.rea'), *options])
        return status, capsys.readouterr().out
    return call


def test_equal_tables_agree(compare):
    assert compare(OLD, OLD) == (0, '')


def test_small_errors_are_measured_against_the_column(compare):
    assert compare(OLD, OLD.replace('top 1.0', 'top 1.00005'))[0] == 0
    assert compare(OLD, OLD.replace('top 1.0', 'top 1.0002'))[0] == 1


def test_the_worst_row_is_named(compare):
    status, text = compare(OLD, OLD.replace('1.0 0.0', '1.1 0.0').replace('100.0', '107.0'))
    assert status == 1
    assert 'R1: 2 of 2 rows differ, worst step 2 top: 100, found 107, error 7' in text


def test_a_column_of_zeros_needs_an_absolute_tolerance(compare):
    new = OLD.replace('100.0 0.0', '100.0 1e-12')
    assert compare(OLD, new)[0] == 1
    assert compare(OLD, new, '--abs', '1e-11')[0] == 0
    assert compare(OLD, new, '--column', 'R2=0,1e-11')[0] == 0


def test_not_a_number_differs(compare):
    assert compare(OLD, OLD.replace('100.0', 'nan'))[0] == 1


def test_names_steps_and_rows_are_exact(compare):
    assert 'set: 1 of 2' in compare(OLD, OLD.replace('2 1.0 top', '2 1.0 bed'))[1]
    assert 'step: 1 of 2' in compare(OLD, OLD.replace('2 1.0 top', '3 1.0 top'))[1]
    assert compare(OLD, OLD + '3 1.5 top 1 1\n')[0] == 1
    assert compare(OLD, OLD.replace('R2', 'R3'))[0] == 1


def test_what_cannot_be_compared_gives_two(compare):
    assert compare(OLD, 'no table\n')[0] == 2
    assert compare(OLD, OLD, '--column', 'R9=1')[0] == 2
    with pytest.raises(SystemExit) as stop:
        compare(OLD, OLD, '--column', 'R1')
    assert stop.value.code == 2
