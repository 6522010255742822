"""Many variants of a run."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Callable, Optional, Union

from .deck import Value, written
from .errors import ConvergenceError
from .result import Result, frame
from .run import DeckLike, Progress, launch

if TYPE_CHECKING:
    import pandas as pd

COUNTS = ('variant', 'exit', 'step', 'iterations', 'cuts')


def study(deck: DeckLike, vary: Mapping[str, Union[str, Iterable[Value]]], *,
          set: Optional[Mapping[str, Value]] = None,
          out: Optional[str | PathLike[str]] = None, threads: int = 1,
          progress: Optional[Callable[[Progress], object]] = None,
          program: Optional[str] = None) -> pd.DataFrame:
    """Runs all combinations of some parameters: a row for each, in the order of the program, with the
    parameters, `exit` (0, or the exit code a run of its own would have had), the last output time `step`,
    the reactions of each set there (`R1:top` and so on), `iterations` and `cuts`.

        mfec.study('sliding_cube.inp', {'phi': [0, 45, 90], 'mu2': '0.02:0.1:0.02'})

    Values are a list, or `from:to:step`. Variants share mesh and factors where they can (doc/manual,
    "Studies"); one that fails has its exit code in its row and stops no other. `attrs['result']` is
    the `Result` of the run with the deck's own values.
    """
    options = ['--threads', str(threads)]
    for name, values in vary.items():
        text = values if isinstance(values, str) else ','.join(map(written, values))
        options += ['--vary', f'{name}={text}']
    try:
        result = launch(deck, options, set, out, progress, program)
    except ConvergenceError as problem:  # of variants alone, if there is a table
        if problem.result is None or '.study' not in problem.result.files:
            raise
        result = problem.result
    table = read_study(result)
    table.attrs['result'] = result
    return table


def read_study(result: Result) -> pd.DataFrame:
    """The table .study of a run."""
    lines = result.path('.study').read_text(encoding='utf-8').split('\n')
    heads = [line[1:].split() for line in lines if line.startswith('#')]
    rows = [line.split() for line in lines if line.strip() and not line.startswith('#')]
    table = frame([[float(word) for word in row] for row in rows], heads[-1])
    return table.astype(dict.fromkeys(COUNTS, 'int64'))
