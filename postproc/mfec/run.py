"""Runs the program and follows it."""
from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import tempfile
import weakref
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import IO, Any, Callable, Optional, Union

from .deck import Deck, Value, written
from .errors import KINDS, MfecError, Problem, StoppedError
from .program import find_program
from .result import Result

DeckLike = Union[Deck, str, 'PathLike[str]']
STEPS = ('iteration', 'end_time', 'cut')


@dataclass(frozen=True)
class Progress:
    """Where a run is: made after each solve, each cut, and each output time."""

    event: str
    """iteration, cut or end_time."""
    step: int
    """The output time it works for, from 1."""
    steps: int
    """Output times in all."""
    time: float
    """Time of the increment."""
    record: Mapping[str, Any]
    """All that the program says (doc/manual, "Output for programs")."""

    @property
    def done(self) -> float:
        """Share of the output times that are on disk."""
        behind = self.step if self.event == 'end_time' else self.step - 1
        return behind / self.steps if self.steps else 0.0

    def __str__(self) -> str:
        if self.event == 'end_time':
            return f'step {self.step} of {self.steps}, time {self.time:g}, {self.record["solves"]} solves'
        if self.event == 'iteration':
            return (f'step {self.step} of {self.steps}, solve {self.record["solve"]}, '
                    f'residual {self.record["relative"] or 0.0:.2g}')
        return f'step {self.step}: cut, {self.record["reason"]}'


def run(deck: DeckLike, *, set: Optional[Mapping[str, Value]] = None,
        out: Optional[str | PathLike[str]] = None, threads: int = 1,
        solver: Optional[str] = None, sens: Union[str, Sequence[str]] = (),
        restart: Optional[str | PathLike[str]] = None, step: Optional[int] = None,
        log: str = 'normal', progress: Optional[Callable[[Progress], object]] = None,
        program: Optional[str] = None) -> Result:
    """Runs a deck to its end.

    deck      its path, or a `Deck`
    set       parameters of the deck with other values: {'mu': 0.2}
    out       folder for the files; without it they lie in one that goes when the result is dropped
    threads   for elements, contact points and large factors
    solver    AUTO, UMFPack, CHOLmod or REDUced
    sens      parameter, or several, to differentiate the reactions by: `result.sensitivities`
    restart   results file to go on from, at its output time `step` or the last one
    log       brief, normal or full
    progress  called with a `Progress` along the way; what it raises stops the run and comes through
    program   the program, if not the one that `find_program` finds

    Raises DeckError (with `problems`), ConvergenceError (with the `result` so far), ResourceError or
    StoppedError. Lines of problems in a `Deck` are those of its `lines`.
    """
    options = ['--threads', str(threads), '--log', log]
    options += ['--solver', solver] if solver else []
    options += ['--sens', ','.join([sens] if isinstance(sens, str) else sens)] if sens else []
    options += ['--restart', os.fspath(restart)] if restart is not None else []
    options += ['--step', str(step)] if step is not None else []
    return launch(deck, options, set, out, progress, program)


def check(deck: DeckLike, *, set: Optional[Mapping[str, Value]] = None,
          out: Optional[str | PathLike[str]] = None, program: Optional[str] = None) -> list[str]:
    """Reads a deck without solving: what the program says of it, line by line; warnings begin with
    `warning:`. Mesh, sets and contact at the start can be looked at in the folder `out`, if there is one
    (x.check.vtkhdf). Raises what a run would raise before its first solve."""
    result = launch(deck, ['--check'], set, out, None, program)
    lines = [str(record['text']) for record in result.records if record['event'] in ('line', 'warning')]
    return lines if out is not None else [line for line in lines if str(result.base.parent) not in line]


def launch(deck: DeckLike, options: Sequence[str], values: Optional[Mapping[str, Value]],
           out: Optional[str | PathLike[str]], progress: Optional[Callable[[Progress], object]],
           program: Optional[str]) -> Result:
    """Runs the program with --json; what it has left, or the exception that it ends with."""
    folder = Path(tempfile.mkdtemp(prefix='mfec-') if out is None else out)
    path = place_of(deck, folder)
    words = [find_program(program), str(path), '--json', '--out', str(folder), *options]
    for name, value in (values or {}).items():
        words += ['--set', f'{name}={written(value)}']
    records: list[Mapping[str, Any]] = []
    with tempfile.TemporaryFile() as said:
        code = follow(words, said, records, progress)
        said.seek(0)
        message = said.read().decode('utf-8', 'replace').strip()
    base = next((record['files'] for record in records if record['event'] == 'start'),
                folder / path.stem)
    result = Result(base, records)
    if out is None:
        weakref.finalize(result, shutil.rmtree, folder, ignore_errors=True)
    if code != 0:
        # A deck that was written for this run alone is named by its name: its folder goes.
        gone = f'{folder}{os.sep}' if out is None and isinstance(deck, Deck) else ''
        raise failure(code, message, result, gone)
    return result


def place_of(deck: DeckLike, folder: Path) -> Path:
    """Where the deck lies as a file: a `Deck` is written beside its results."""
    if not isinstance(deck, Deck):
        return Path(deck)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / (deck.path.name if deck.path else 'deck.inp')
    if deck.path is not None and path.exists() and path.samefile(deck.path):
        if path.read_text(encoding='utf-8') == deck.text:
            return path
        raise ValueError(f'the changed deck would be written over {path}: give another folder out')
    return deck.write(path)


def follow(words: Sequence[str], said: IO[bytes], records: list[Mapping[str, Any]],
           progress: Optional[Callable[[Progress], object]]) -> int:
    """Reads the records of the program as they come; its exit code."""
    with running(words, said) as process:
        assert process.stdout is not None
        for line in process.stdout:
            try:
                record = json.loads(line)
            except ValueError:  # the last line of a program that was killed
                continue
            records.append(record)
            if progress is not None and record['event'] in STEPS:
                progress(Progress(record['event'], record['step'], record.get('steps', 0),
                                  record['time'], record))
        return process.wait()


@contextlib.contextmanager
def running(words: Sequence[str], said: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """The program at work; it is stopped, its files closed, when the caller leaves early."""
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=said,
                          stdin=subprocess.DEVNULL) as process:
        try:
            yield process
        finally:
            if process.poll() is None:
                process.terminate()


def failure(code: int, message: str, result: Result, gone: str = '') -> MfecError:
    """The exception of an exit code; `gone` is left out in front of the names of files, if nothing is on
    disk there."""
    end = result.of('end')
    kind = KINDS.get(end[-1]['reason'], MfecError) if end else StoppedError
    begun = result if result.of('start') else None
    problems = [Problem.of(record) for record in result.of('problem')]
    if gone and begun is None:
        message = message.replace(gone, '')
        problems = [replace(problem, file=problem.file.replace(gone, '')) for problem in problems]
    return kind(message or f'mfec ended with exit code {code}', code, problems, begun)
