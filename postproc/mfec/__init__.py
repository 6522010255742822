"""mfec from Python: run decks, change them, read what comes out.

    import mfec

    result = mfec.run('sliding_cube.inp', set={'phi': 45}, progress=print)
    result.reactions                      # pandas tables: reactions, contact, audit, iterations, ...
    result.field('displacement')          # numpy: (points, 3) at the last output time

    deck = mfec.Deck.read('sliding_cube.inp')
    deck['mu1'] = 0.3
    mfec.run(deck)

    mfec.study('sliding_cube.inp', {'phi': [0, 45, 90]})     # one row a variant

A deck with errors raises `DeckError`, whose `problems` say file, line, column, what is wrong and what
would be right; a run that does not converge raises `ConvergenceError` with the `result` so far.
"""
from __future__ import annotations

from .deck import Deck, Record
from .errors import ConvergenceError, DeckError, MfecError, Problem, ResourceError, StoppedError
from .examples import copy_examples, example, examples
from .program import find_program, program_version
from .result import Result
from .run import Progress, check, run
from .study import study

__all__ = ['ConvergenceError', 'Deck', 'DeckError', 'MfecError', 'Problem', 'Progress', 'Record',
           'ResourceError', 'Result', 'StoppedError', 'check', 'copy_examples', 'example', 'examples',
           'find_program', 'program_version', 'run', 'study']
__version__ = '1.0.0'
