"""The lines of a proof: what each reads, how far it may be off, and where it comes from; and the
ledger that judges by them. Nothing of mfec or of the other modules here is used by the proof: what
is proved must not rest on what is to be proved."""
from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray as Array

ROUND_OFF = 2.0 ** -52
PLAIN, AUGMENTED, MORTAR = 0, 1, 2


class Line(NamedTuple):
    """A line; errors are relative to forces, sizes or edges as the formula says."""
    reads: str
    source: str  # chapter of doc/theory.md
    plain: float
    augmented: float = 0.0  # with AUGMent, 0: as plain
    mortar: float = 0.0  # with MORTar, whose weights settle at 1e-6; 0: as plain

    def tolerance(self, form: int) -> float:
        """The tolerance of a form of contact."""
        return (self.plain, self.augmented or self.plain, self.mortar or self.plain)[form]


LINES = {
    # bodies
    'equilibrium of the nodes': Line('displacement, reaction, traction, loads', '2, 8', 1e-8, 1e-5, 5e-6),
    'resultant force': Line('reaction, traction, loads', '2', 1e-8, 1e-5, 5e-6),
    'no moment from inside': Line('displacement', '8', 1e-8),
    'no reaction without support': Line('reaction, supports', '2', 1e-8, 1e-5, 5e-6),
    'springs': Line('reaction, displacement, springs', '2', 1e-8),
    'held regions carry nothing': Line('reaction', '11', 1e-6),
    'prescribed displacements': Line('displacement, loads, tables', '2', 1e-10),
    'rigid bodies': Line('displacement', '9', 1e-10),
    'rigid bodies: balance': Line('reaction, rigid_loads', '9', 1e-8, 1e-5, 5e-6),
    'stress of the cells': Line('displacement, stress', '8', 1e-9),
    'von Mises stress': Line('stress, nodal_stress', '8.8', 1e-12),
    # contact, each point
    'contact: action, reaction': Line('traction, tip', '3', 1e-11),
    'contact: no moment': Line('traction, tip', '3', 1e-11),
    'open points: no force': Line('status, traction', '3', 1e-12),
    'open points: no penetration': Line('status, displacement', '3', 1e-9),
    'gap': Line('displacement, gap', '3', 1e-9),
    'tip inside its facet': Line('tip', '10', 1e-2),
    'penalty of the deck': Line('epsilon, area, law', '7', 1e-12),
    'penalty law': Line('traction, displacement, tip', '3', 1e-8, 1e-5),
    'AUGMent: tips without gap': Line('displacement, tip', '7', np.inf),
    'pressure, no tension': Line('traction', '3', 1e-12, 0, 1e-8),
    'closed: no gap': Line('gap', '3', 1e-10),
    'pressure of the depth': Line('lay_traction, gap', '3', 1e-9),
    'forces along the lay': Line('lay_traction, traction, lay', '4', 1e-9),
    'elastic slip': Line('elastic_slip, displacement, tip', '3', 1e-9),
    'lay': Line('lay, law', '5', 1e-9),
    'cone': Line('traction, lay', '4', 1e-8, 0, 5e-6),
    'cone where it slips': Line('traction, lay', '4', 1e-8, 0, 5e-6),
    'no friction without mu': Line('traction', '4', 1e-8),
    'stick: the apex rests': Line('tip, start_tip', '4', 1e-12),
    'slip rule': Line('tip, start_tip, traction', '4', 1e-5, 0, 1e-4),
    # contact, from one output time to the next
    'history': Line('start_tip, tip before', '10', 1e-10),
    'history over an edge': Line('start_tip, tip before', '10', 1e-7),
    'history of new cells': Line('start_tip, tip before', '6.4', 1e-7),
    'dissipation': Line('dissipation, traction, tip', '13', 1e-6, 0, 1e-5),
    'dissipation, no gain': Line('traction, tip', '13', 1e-6, 0, 1e-5),
    'slip path': Line('slip_path, tip', '13', 1e-9, 0, 1e-6),
    'slip vector': Line('frictional_slip, tip', '13', 1e-9, 0, 1e-6),
    # cells of SEGMent and MORTar
    'cells: no overlap': Line('node, weight, area', '6', 1e-9),
    'cells: cover what is over': Line('area, displacement', '6', 1e-9),
    'cells: exact on whole facets': Line('weight, area', '6', 1e-6),
    # multipliers
    'multipliers: one a node': Line('traction, weight, area', '7.7', 1e-9),
    'multipliers: no gap': Line('displacement, weight', '7.7', 1e-9),
    'multipliers: open, no penetration': Line('displacement, weight', '7.7', 1e-9),
    # tables and audit
    'table of reactions': Line('history/reactions', '2', 1e-9),
    'table of contact: points': Line('history/contact, status', '3', 0.5),
    'table of contact: forces': Line('history/contact, traction', '3', 1e-9, 0, 1e-8),
    'table of contact: lengths': Line('history/contact, gap, elastic_slip', '3', 1e-9),
    'energy: strain': Line('displacement, audit', '13', 1e-6),
    'energy: penalty': Line('traction, gap, audit', '13', 1e-6),
    'energy: friction': Line('dissipation, audit', '13', 1e-6),
}


class Ledger:
    """The lines of a proof: the worst number of each against its tolerance, and what is open."""

    def __init__(self) -> None:
        self.lines: dict[str, dict[str, Any]] = {}
        self.gaps: dict[tuple[str, str], int] = {}
        self.step, self.form = 0, PLAIN

    def judge(self, name: str, error: Any, who: Optional[Array] = None, blur: Any = 0.0) -> None:
        """Errors (relative already) that must not exceed the tolerance, and blur, of round-off;
        `who` names the rows. A number that is none is refuted."""
        values = np.abs(np.atleast_1d(np.asarray(error, float)))
        if values.size == 0:
            return
        values = values.reshape(len(values), -1).max(1)
        values = np.where(np.isfinite(values), values, np.inf)
        tolerance = LINES[name].tolerance(self.form)
        values = values / (1 + np.asarray(blur) / tolerance)
        at = int(values.argmax())
        line = self.lines.setdefault(name, {'worst': -1.0, 'tolerance': tolerance, 'count': 0,
                                            'step': 0, 'what': '', 'bad': 0})
        line['count'] += values.size
        line['bad'] += int((values > tolerance).sum())
        if values[at] / tolerance > line['worst'] / line['tolerance']:
            line.update(worst=float(values[at]), tolerance=tolerance, step=self.step,
                        what='' if who is None else str(np.ravel(who)[at]))

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
