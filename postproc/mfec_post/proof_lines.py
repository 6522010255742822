"""The lines of a proof with their tolerances, and the ledger that judges by them. Nothing of mfec or
of the other modules here is used by the proof: what is proved must not rest on what is to be proved."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray as Array

ROUND_OFF = 2.0 ** -52
PLAIN, AUGMENTED, MORTAR = 0, 1, 2  # forms of contact, of the tolerances
BALANCE, CONE = (1e-8, 1e-5, 1e-8), (1e-8, 1e-8, 1e-6)
WORK, WAY = (1e-6, 1e-6, 5e-6), (1e-9, 1e-9, 1e-8)


TABLE: tuple[tuple[Any, str], ...] = (  # errors are relative to forces, sizes or edges; one number: all forms
    # bodies
    (BALANCE, 'equilibrium of the nodes|resultant force|no reaction without support|rigid bodies: balance'),
    (1e-6, 'held regions carry nothing'),
    (1e-8, 'no moment from inside|springs'),
    (1e-9, 'stress of the cells|nodal stress'),
    (1e-10, 'prescribed displacements|rigid bodies'),
    (1e-12, 'von Mises stress'),
    # contact, each point
    (1e-11, 'contact: action, reaction|contact: no moment'),
    (1e-12, 'open points: no force|stick: the apex rests|penalty of the deck'),
    (1e-9, 'open points: no penetration|open points: apex below|gap|lay|lay of the nodes|'
           'forces along the lay|elastic slip|'
           'pressure of the depth|patches of SMOOth|height over slave facets'),
    (1e-10, 'closed: no gap'),
    (1e-4, 'apex inside its facet'),
    ((1e-8, 1e-5, 1e-8), 'penalty law'),
    (1.0, 'AUGMent: apexes without gap'),
    ((1e-12, 1e-12, 1e-8), 'pressure, no tension'),
    (CONE, 'cone|cone where it slips'),
    (1e-8, 'no friction without mu'),
    (1e-5, 'slip rule'),
    # contact, from one output time to the next
    (1e-10, 'history'),
    (1e-7, 'history over an edge|history of new cells'),
    (5e-7, 'first touch'),
    (WORK, 'dissipation|dissipation, no gain'),
    (WAY, 'slip path|slip vector'),
    # cells of SEGMent and MORTar, multipliers
    (1e-9, 'cells: no overlap|cells: cover what is over|points: areas of their facets|'
           'multipliers: one a node|multipliers: apexes|multipliers: no gap|'
           'multipliers: open, no penetration'),
    (1e-6, 'points: exact on whole facets'),
    (5e-3, 'cells: clips of facets'),
    (1e-4, 'cells: where their points are'),
    # tables and audit
    (1e-9, 'table of reactions|table of contact: lengths'),
    (0.5, 'table of contact: points'),
    ((1e-9, 1e-9, 1e-8), 'table of contact: forces'),
    (1e-6, 'energy: strain|energy: penalty|energy: friction'))
LINES = {name: tolerance if isinstance(tolerance, tuple) else (tolerance,) * 3
         for tolerance, names in TABLE for name in names.split('|')}


def strays(off: Array, least: float, most: float, share: float) -> Array:
    """Which numbers are beyond `least` (up to `most`), where these are few: the program stops following
    points that go to and fro, and cells that have been cut four times in an increment."""
    stray = (off > least) & (off < most)
    return np.asarray(stray & (stray.sum() <= max(2, share * len(off))))


class Ledger:
    """The lines of a proof: the worst number of each against its tolerance, and what is open."""

    def __init__(self) -> None:
        self.lines: dict[str, dict[str, Any]] = {}
        self.gaps: dict[tuple[str, str], int] = {}
        self.step, self.form = 0, PLAIN

    def judge(self, name: str, error: Any, who: Optional[Array] = None, blur: Any = 0.0,
              only: Any = slice(None)) -> None:
        """Errors (relative already) that must not exceed the tolerance, and blur, of round-off;
        `who` names the rows, `only` chooses some. A number that is none is refuted."""
        values = np.abs(np.atleast_1d(np.asarray(error, float)))
        blur = np.broadcast_to(blur, len(values))[only]
        values = values[only]
        if values.size == 0:
            return
        values = values.reshape(len(values), -1).max(1)
        values = np.where(np.isfinite(values), values, np.inf)
        tolerance = LINES[name][self.form]
        values = values / (1 + blur / tolerance)
        at = int(values.argmax())
        line = self.lines.setdefault(name, {'worst': -1.0, 'tolerance': tolerance, 'count': 0,
                                            'step': 0, 'what': '', 'bad': 0})
        line['count'] += values.size
        line['bad'] += int((values > tolerance).sum())
        if values[at] / tolerance > line['worst'] / line['tolerance']:
            line.update(worst=float(values[at]), tolerance=tolerance, step=self.step,
                        what='' if who is None else str(np.ravel(who)[only][at]))

    def leave(self, name: str, why: str, count: Any = 1) -> None:
        """Says what the files do not hold enough for."""
        if int(count):
            self.gaps[name, why] = self.gaps.get((name, why), 0) + int(count)

    def count(self) -> dict[str, int]:
        """Numbers of lines: proved, open, refuted."""
        refuted = sum(line['bad'] > 0 for line in self.lines.values())
        return {'proved': len(self.lines) - refuted, 'open': len(self.gaps), 'refuted': refuted}

    def rows(self) -> list[str]:
        """One line each, as text."""
        rows = []
        for name, line in self.lines.items():
            text = f'{name:33s} {"REFUTED" if line["bad"] else "proved":8s} ' \
                f'{line["worst"]:9.1e} of {line["tolerance"]:7.0e}  {line["count"]} numbers'
            if line['bad']:
                text += f', {line["bad"]} refuted; worst at step {line["step"]} {line["what"]}'
            rows.append(text.rstrip())
        return rows + [f'{name:33s} open     {count} times: {why}'
                       for (name, why), count in self.gaps.items()]
