"""What can go wrong, as exceptions: one class for each kind of exit code (doc/manual, "Command line")."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    from .result import Result


@dataclass(frozen=True)
class Problem:
    """One error of a deck."""

    file: str
    """Name of the file, `command line` for what was set by arguments."""
    line: int
    """Its line, from 1; 0 without a place."""
    column: int
    """Its column, from 1; 0 without a place."""
    what: str
    """What is wrong."""
    text: str
    """The line as it stands in the file."""
    remedy: str
    """What would be right."""

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> Problem:
        """A problem from a record of `--json`."""
        return cls(*(record[name] for name in ('file', 'line', 'column', 'what', 'text', 'remedy')))

    def __str__(self) -> str:
        place = f'{self.file}:{self.line}:{self.column}' if self.line else self.file
        return f'{place}: {self.what}' + (f' ({self.remedy})' if self.remedy else '')


class MfecError(Exception):
    """A run that did not come to its end."""

    def __init__(self, message: str, code: int = 1, problems: Sequence[Problem] = (),
                 result: Optional[Result] = None):
        super().__init__(message)
        self.message = message
        """All that the program says: what, where, what to do."""
        self.code = code
        """Its exit code."""
        self.problems = list(problems)
        """Errors of the deck with their places and remedies."""
        self.result = result
        """What is on disk, if the run has begun."""

    @property
    def remedy(self) -> str:
        """What would be right: of the first problem, or what stands below the message's first line."""
        if self.problems:
            return self.problems[0].remedy
        return '\n'.join(line.strip() for line in self.message.split('\n')[1:])


class DeckError(MfecError):
    """Errors in the deck or among the arguments; nothing was computed or written."""


class ConvergenceError(MfecError):
    """No convergence, a body that nothing holds, an audit that failed; `result` ends before that."""


class ResourceError(MfecError):
    """A file that cannot be written, or no memory."""


class StoppedError(MfecError):
    """The run was stopped by a signal, or broke down."""


KINDS: dict[str, type[MfecError]] = {
    'deck': DeckError, 'no_convergence': ConvergenceError, 'resources': ResourceError,
    'stopped': StoppedError}
