"""mfec.Deck: records, parameters, changes, and files that a deck names."""
import mfec
import pytest
from mfec.deck import items_of

TEXT = """MFEC * * A title

PARAmeter
  mu = 0.1     ! of friction
  shear = 210e3/(2*(1+0.3))
! not the end of the set
  way=2

CONTact
  PAIR 1 sole
    PENAlty   AUTO 10   ! stiff
  LIST 1, 2,,3 &
    4 5
BATCh
  DT,,1/8
END
"""


def test_items():
    """Blanks, commas and = part items; two commas leave an empty one; quotes hold blanks."""
    assert items_of('STEP,,n') == ('STEP', '', 'n')
    assert items_of(' mu =  0.1 ') == ('mu', '0.1')
    assert items_of("MESH 'my part.msh' AS x") == ('MESH', "'my part.msh'", 'AS', 'x')
    assert items_of('1 , 2') == ('1', '2')
    assert items_of('') == ()


def test_reading():
    """Title, parameters, records with their lines."""
    deck = mfec.Deck(TEXT)
    assert deck.title == 'A title' and str(deck) == TEXT
    assert deck.parameters == {'mu': '0.1', 'shear': '210e3/(2*(1+0.3))', 'way': '2'}
    assert 'mu' in deck and 'PENA' not in deck and deck['way'] == '2'
    listed = list(deck.records('list'))[0]
    assert (listed.line, listed.last, listed.items) == (12, 13, ('LIST', '1', '2', '', '3', '4', '5'))
    assert [r.items[0] for r in deck.records('DT')] == ['DT']


def test_changes():
    """Values change, comments and all other lines stay."""
    deck = mfec.Deck(TEXT)
    deck['mu'] = 0.30000000000000004
    deck['way'] = 'mu*2'
    deck.change('PENA', 'AUTO', 100)
    assert '  mu = 0.30000000000000004     ! of friction' in deck.lines
    assert '  way=mu*2' in deck.lines and '    PENAlty AUTO 100   ! stiff' in deck.lines
    changed = [a for a, b in zip(deck.lines, TEXT.split('\n')) if a != b]
    assert len(changed) == 3
    with pytest.raises(KeyError, match='it has: mu'):
        deck['muh'] = 1
    with pytest.raises(KeyError, match='it has: mu'):
        deck['muh']  # noqa: B018
    with pytest.raises(ValueError, match='no blanks'):
        deck['mu'] = '1 + 2'
    with pytest.raises(KeyError):
        deck.change('FRICtion', 'COULomb', 0.1)


def test_insert_and_remove():
    """Lines come behind a record, records go whole."""
    deck = mfec.Deck(TEXT)
    record = list(deck.records('LIST'))[0]
    deck.insert(record, '  SMOOth')
    assert deck.lines[13] == '  SMOOth'
    deck.remove(record)
    assert 'LIST' not in deck.text and '4 5' not in deck.text and '  SMOOth' in deck.lines


def test_every_example_is_read():
    """Parameters of all examples are those that the program knows: setting one to itself changes
    nothing."""
    for name in mfec.examples():
        deck = mfec.Deck.read(mfec.example(name))
        before = deck.text
        for parameter, value in deck.parameters.items():
            deck[parameter] = value
        assert deck.text == before, name


def test_a_changed_deck_runs_elsewhere(tmp_path):
    """A mesh beside the deck is found from a folder of its own, and the original stays."""
    path = mfec.example('sphere_on_plate')
    deck = mfec.Deck.read(path)
    assert list(deck.records('MESH'))
    lines = mfec.check(deck)
    assert lines[0] == mfec.check(path)[0]
    written = deck.write(tmp_path / 'other.inp')
    assert str(path.parent) in written.read_text() and deck.text == path.read_text()
    copy = mfec.Deck.read(written)
    copy.change('DT', '', 0.125)
    with pytest.raises(ValueError, match='another folder'):
        mfec.run(copy, out=tmp_path)


def test_parameters_reach_the_run():
    """What a changed deck computes is what --set computes."""
    path = mfec.example('manual/pulled_block')
    deck = mfec.Deck.read(path)
    deck['young'] = 2000
    mine, other = mfec.run(deck), mfec.run(path, set={'young': 2000})
    assert mine.reactions.equals(other.reactions)
    assert mine.reactions['R3'].abs().max() == pytest.approx(20.0)
