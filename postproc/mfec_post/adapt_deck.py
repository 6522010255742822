"""Decks for adapted runs: facets of six nodes, labels for mesh files, little output; goals in tables."""
from __future__ import annotations

import re
from typing import Optional

import numpy as np
from mfec.deck import Deck

from .results import Results

POINTS = 6
"""Points of a slave facet that the pressures of T10 need."""
LABEL = 'adapt_material_'


class GoalError(Exception):
    """A goal that no table holds."""


class Goal:
    """`set.R1`, `pair:F1`, or a quotient of two such."""

    def __init__(self, text: str):
        self.text = text
        self.terms = []
        for word in text.split('/'):
            found = re.fullmatch(r'([\w-]+)([.:])(\w+)', word.strip())
            if not found:
                raise GoalError(f'{text}: a goal is set.R1 (a reaction) or pair:F1 (a column of the contact '
                                'table), or a quotient of two')
            self.terms.append(found.groups())
        if len(self.terms) > 2:
            raise GoalError(f'{text}: a quotient has two parts')

    def value(self, results: Results, time: Optional[float] = None) -> float:
        """At an output time, or at the last."""
        values = [term_value(results, name, sign, column, time) for name, sign, column in self.terms]
        if len(values) == 1:
            return values[0]
        if values[1] == 0.0:
            raise GoalError(f'{self.text}: the divisor is zero')
        return values[0] / values[1]


def term_value(results: Results, name: str, sign: str, column: str, time: Optional[float] = None) -> float:
    """A column of a row of a set or a pair, of the last unless a time is given."""
    kind, key = ('reactions', 'set') if sign == '.' else ('contact', 'pair')
    table = results.history(kind)
    names = list(dict.fromkeys(map(str, table.get(key, []))))
    if name not in names:
        raise GoalError(f'{name}{sign}{column}: the table of {kind} has no {key} {name}; it has: '
                        + ', '.join(names))
    if column not in table:
        raise GoalError(f'{name}{sign}{column}: the table of {kind} has the columns '
                        + ', '.join(set(table) - {'step', 'time', key}))
    rows = np.flatnonzero(table[key] == name)
    row = rows[-1] if time is None else rows[np.argmin(np.abs(table['time'][rows] - time))]
    return float(table[column][row])


def own_names(deck: Deck) -> set[str]:
    """Sets and surfaces that the deck defines."""
    return {record.items[1].strip('\'"') for word in ('SET', 'SURF') for record in deck.records(word)
            if record.word.strip() in ('set', 'surf') and len(record.items) > 1}


def prepare(deck: Deck, surfaces: set[str], order: int, labels: bool) -> tuple[Deck, list[str]]:
    """The deck of the runs, and what it says otherwise than the user's. Its mesh commands stay: the
    option --mesh takes their place."""
    deck = Deck(deck.text, deck.path)
    notes: list[str] = []
    if labels:
        for k, record in enumerate(list(deck.records('MATE'))):
            deck.change('MATE', record.items[1], LABEL + record.items[1], nth=k)
    if order == 2:
        to_facets(deck, surfaces, notes)
    while order == 2 and has_word(deck, 'SMOO'):  # facets of six nodes bend by themselves
        notes.append('SMOOth is left out: facets of six nodes are curved')
        deck.remove(next(deck.records('SMOO')))
    ask_for_fields(deck)
    return deck, notes


def to_facets(deck: Deck, surfaces: set[str], notes: list[str]) -> None:
    """NTOS becomes GTOS, which facets of six nodes want, with points enough for them."""
    extra = []
    for k, record in enumerate(list(deck.records('NTOS'))):
        slave = record.items[1]
        if slave.strip('\'"') not in surfaces:
            name = f'adapt_slave_{k + 1}'
            extra += ['', f'SURFace {name} FROM {slave}', '']
            slave = name
        notes.append(f'NTOS {record.items[1]} {record.items[2]} becomes GTOS with {POINTS} points a facet')
        line = deck.lines[record.line - 1]
        head = line[:len(line) - len(line.lstrip())]
        deck.remove(record)
        deck.insert(record.line - 1, f'{head}GTOS {slave} {record.items[2]} {POINTS}')
    for k, record in enumerate(list(deck.records('GTOS'))):
        points = record.items[3] if len(record.items) > 3 else '0'
        if points.isdigit() and int(points) < POINTS:
            deck.change('GTOS', *record.items[1:3], POINTS, nth=k)
    if extra:
        deck.insert(next(deck.records('CONT')).line - 1, *extra)


def ask_for_fields(deck: Deck) -> None:
    """Displacements and contact points, no states."""
    for word in ('FIEL', 'STAT', 'POIN'):
        while True:
            record = next(deck.records(word), None)
            if record is None or (word == 'POIN' and not has_word(deck, 'OUTP')):
                break
            if word == 'POIN' and not is_request(deck, record.line):
                break
            deck.remove(record)
    wanted = ['  FIELds displacement contact', '  STATe NONE']
    record = next(deck.records('OUTP'), None)
    if record is not None:
        deck.insert(record, *wanted)
        return
    end = next(r for r in deck.records() if r.word in ('end', 'batc', 'macr'))
    deck.insert(end.line - 1, '', 'OUTPut', *wanted, '')


def has_word(deck: Deck, word: str) -> bool:
    """Some record begins with a word."""
    return next(deck.records(word), None) is not None


def is_request(deck: Deck, line: int) -> bool:
    """POINts of OUTPut, not POINt of RIGId: the last command before it is OUTPut."""
    last: Optional[str] = None
    for record in deck.records():
        if record.line >= line:
            break
        if record.word in ('outp', 'rigi'):
            last = record.word
    return last == 'outp'
