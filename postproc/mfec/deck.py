"""Decks: read, change, write (doc/manual, "The deck language")."""
from __future__ import annotations

import numbers
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Optional, Union

Value = Union[str, int, float]
FILES = ('incl', 'mesh')  # commands that name a file, relative to the one that has them


@dataclass(frozen=True)
class Record:
    """A record of a deck: its first line, its last one if `&` continues it, and its items."""

    line: int
    """Number of its first line, from 1, as in messages of the program."""
    last: int
    """Number of its last line."""
    items: tuple[str, ...]
    """What stands between blanks, commas and `=`; an empty field is ''."""

    @property
    def word(self) -> str:
        """Its keyword as it counts: four letters, lower case."""
        return self.items[0][:4].lower() if self.items else ''


def without_comment(line: str) -> str:
    """What stands before `!`."""
    return line.split('!', 1)[0].rstrip()


def items_of(text: str) -> tuple[str, ...]:
    """The items of a record; a text in quotes is one."""
    text = re.sub(r'[ \t]*([,=])[ \t]*', r'\1', text.strip())
    found, item, quote = [], '', ''
    for letter in text:
        if quote or letter in '\'"':
            quote = '' if letter == quote else quote or letter
            item += letter
        elif letter in ' \t,=':
            if item or letter in ',=':
                found.append(item)
            item = ''
        else:
            item += letter
    return tuple(found + [item] if item else found)


class Deck:
    """A deck as text that can be asked and changed. Parameters are its items:

        deck = Deck.read('sliding_cube.inp')
        deck['mu1'], deck['young'] = 0.3, 'shear*2.6'
        deck.change('PENAlty', 'AUTO', 100)
        deck.write('stiffer.inp')

    Lines that nothing changes stay as they are, comments included.
    """

    def __init__(self, text: str, path: Optional[str | PathLike[str]] = None):
        self.lines = text.split('\n')
        """Its lines."""
        self.path = Path(path) if path is not None else None
        """Where it was read from: files that it names are looked for beside it."""

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Deck:
        """A deck from a file."""
        return cls(Path(path).read_text(encoding='utf-8'), path)

    @property
    def text(self) -> str:
        """All of it."""
        return '\n'.join(self.lines)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f'<Deck {self.title!r}, {len(self.lines)} lines, {len(self.parameters)} parameters>'

    @property
    def title(self) -> str:
        """What stands behind MFEC * * or FEAP * *."""
        for line in self.lines:
            found = re.match(r'\s*(?:MFEC|FEAP)\s*\*\s*\*\s?(.*)', line, re.I)
            if found:
                return found.group(1).strip()
        return ''

    def records(self, word: Optional[str] = None) -> Iterator[Record]:
        """All records, or those that begin with a word: `deck.records('PAIR')`."""
        start, text = 0, ''
        for number, line in enumerate(self.lines, 1):
            code = without_comment(line)
            start = start or number
            if code.endswith('&'):
                text += code[:-1] + ' '
                continue
            items = items_of(text + code)
            if items and (word is None or items[0][:4].lower() == word[:4].lower()):
                yield Record(start, number, items)
            start, text = 0, ''

    def _definitions(self) -> dict[str, Record]:
        """Parameters with the records that define them last."""
        found, inside = {}, False
        for record in self.records():
            blank = record.line > 1 and not self.lines[record.line - 2].strip()
            if record.word == 'para':
                inside = True
            elif inside and not blank and re.search(r'^\s*\w+\s*=', self.lines[record.line - 1]):
                found[record.items[0]] = record
            else:
                inside = False
        return found

    def _definition(self, name: str) -> Record:
        """The record that defines a parameter."""
        defined = self._definitions()
        if name not in defined:
            raise KeyError(f'the deck has no parameter {name}; it has: ' + ', '.join(defined))
        return defined[name]

    @property
    def parameters(self) -> dict[str, str]:
        """Parameters and the expressions that are their values."""
        return {name: ' '.join(record.items[1:]) for name, record in self._definitions().items()}

    def __getitem__(self, name: str) -> str:
        """The expression that is a parameter's value."""
        return ' '.join(self._definition(name).items[1:])

    def __contains__(self, name: str) -> bool:
        return name in self._definitions()

    def __setitem__(self, name: str, value: Value) -> None:
        """Gives a parameter of the deck another value, a number or an expression."""
        record = self._definition(name)
        if re.search(r'\s', str(value)):
            raise ValueError(f'an expression has no blanks: {value!r}')
        line = self.lines[record.line - 1]
        head = re.match(r'\s*\w+\s*=\s*', line)
        assert head is not None
        self._replace(record, head.group() + written(value))

    def change(self, word: str, *items: Value, nth: int = 0) -> None:
        """Replaces what stands behind a word, in the nth record that begins with it (from 0)."""
        found = list(self.records(word))
        if nth >= len(found):
            raise KeyError(f'the deck has {len(found)} records {word}')
        line = self.lines[found[nth].line - 1]
        head = line[:len(line) - len(line.lstrip())] + found[nth].items[0]
        self._replace(found[nth], ' '.join([head, *map(written, items)]))

    def insert(self, after: int | Record, *lines: str) -> None:
        """Puts lines behind a record, or behind the line of a number (0: at the beginning)."""
        place = after.last if isinstance(after, Record) else after
        self.lines[place:place] = lines

    def remove(self, record: Record) -> None:
        """Takes a record away."""
        del self.lines[record.line - 1:record.last]

    def _replace(self, record: Record, code: str) -> None:
        """Puts code in place of a record; a comment in its last line stays."""
        last = self.lines[record.last - 1]
        comment = last[len(without_comment(last)):]
        self.lines[record.line - 1:record.last] = [code + comment]

    def write(self, path: str | PathLike[str]) -> Path:
        """Writes it; what it names beside its old place is named by a path that still holds."""
        path = Path(path)
        path.write_text(self.moved_to(path.parent).text, encoding='utf-8')
        return path

    def moved_to(self, folder: str | PathLike[str]) -> Deck:
        """A deck with the same meaning in another folder: INCLude and MESH name their files there."""
        moved = Deck(self.text, Path(folder) / (self.path.name if self.path else 'deck.inp'))
        if self.path is None or self.path.parent.resolve() == Path(folder).resolve():
            return moved
        for record in [r for r in self.records() if r.word in FILES and len(r.items) > 1]:
            name = record.items[1]
            there = self.path.parent.resolve() / name.strip('\'"')
            if not os.path.isabs(name.strip('\'"')) and there.exists():
                line = moved.lines[record.line - 1]
                moved.lines[record.line - 1] = line.replace(name, f"'{there}'", 1)
        return moved


def written(value: Value) -> str:
    """A value as a deck has it, all digits of a real."""
    if isinstance(value, bool) or not isinstance(value, (str, numbers.Real)):
        raise TypeError(f'{value!r} is neither a number nor an expression')
    return str(value) if isinstance(value, (str, numbers.Integral)) else repr(float(value))
