"""The reader of tables."""
import numpy as np
import pytest
from mfec_post import TableError, read_table, rows_of

REA = '''# title with set and step in it
# reactions: what the support does
#   step                   time  set                      R1                     R2
       1    5.000000000000E-001  top     1.000000000000E+000    0.000000000000E+000
       1    5.000000000000E-001  ground -1.000000000000E+000    1.000000000000E-200
'''


def write(path, text):
    path.write_text(text)
    return str(path)


def test_columns_have_names_and_types(tmp_path):
    table = read_table(write(tmp_path / 'x.rea', REA))
    assert table.dtype.names == ('step', 'time', 'set', 'R1', 'R2')
    assert table['step'].dtype.kind == 'i'
    assert list(table['set']) == ['top', 'ground']
    np.testing.assert_array_equal(table['R2'], [0.0, 1e-200])


def test_rows_of_one_set(tmp_path):
    table = read_table(write(tmp_path / 'x.rea', REA))
    assert rows_of(table, 'ground')['R1'][0] == -1.0
    with pytest.raises(TableError, match='ground, top'):
        rows_of(table, 'side')


def test_the_torn_last_line_of_a_killed_run_is_dropped(tmp_path):
    table = read_table(write(tmp_path / 'x.rea', REA + '       2    1.0000000'))
    assert len(table) == 2


def test_a_table_without_rows_is_a_table(tmp_path):
    assert len(read_table(write(tmp_path / 'x.rea', REA[:REA.index('       1')]))) == 0


@pytest.mark.parametrize('text, words', [
    ('1 2 3\n', 'no header'),
    (REA + '2 1.0 top 1.0\n', 'x.rea:6: 4 items, 5 columns'),
    (REA + '2 1.0 top 1.0 one\n', 'x.rea:6'),
])
def test_what_is_wrong_is_said(tmp_path, text, words):
    with pytest.raises(TableError, match=words):
        read_table(write(tmp_path / 'x.rea', text))


def test_a_missing_file_is_said(tmp_path):
    with pytest.raises(TableError, match='none.rea'):
        read_table(str(tmp_path / 'none.rea'))


def test_table_of_points(tmp_path):
    """Its column slip is a way, not a count."""
    table = read_table(write(tmp_path / 'x.pts', """# x
# points
#   step time pair point status p t1 t2 t3 gap slip
1 0.5 lid 12 2 1.5 0.1 0.0 0.0 -1e-3 2.5e-2
"""))
    assert table['point'][0] == 12 and table['status'][0] == 2
    assert table['slip'][0] == 2.5e-2


def test_a_table_of_rigid_bodies_has_rows_by_their_names(tmp_path):
    path = tmp_path / 'x.rig'
    path.write_text('# step time body U1\n 1 0.5 pin 0.25\n 1 0.5 tool 0.5\n', encoding='ascii')
    assert rows_of(read_table(str(path)), 'tool')['U1'].tolist() == [0.5]
