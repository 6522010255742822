"""What a run has written, as tables of pandas and arrays of numpy."""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:  # what takes long to import is imported by whoever needs it: the command does not
    import pandas as pd
    from mfec_post.results import Results
    from mfec_post.surfaces import Surface
    from numpy.typing import NDArray

Records = Sequence[Mapping[str, Any]]


def frame(rows: Any, columns: Optional[Sequence[str]] = None) -> pd.DataFrame:
    """Rows as a table of pandas."""
    import pandas
    return pandas.DataFrame(rows, columns=columns)


class Result:
    """A run: its tables, fields and audit, and how it went.

    `mfec.run` makes one; `Result('folder/x')` opens what an earlier run has left (its `records` are
    empty then, and with them iterations, costs and warnings).
    """

    def __init__(self, base: str | PathLike[str], records: Records = ()):
        text = os.fspath(base)
        for ending in ('.contact.vtkhdf', '.vtkhdf', '.rea', '.con', '.log', '.inp'):
            if text.endswith(ending):
                text = text[:-len(ending)]
                break
        self.base = Path(text)
        """Path of the files without their endings."""
        self.records = list(records)
        """What the program told along the way (doc/manual, "Output for programs")."""

    def __repr__(self) -> str:
        end = self.of('end_time')
        went = f', {len(end)} output times, {self.seconds:.3g} s, audit {self.verdict}' if end else ''
        return f'<Result {self.base}{went}>'

    def of(self, event: str) -> list[Mapping[str, Any]]:
        """The records of an event."""
        return [record for record in self.records if record['event'] == event]

    @property
    def files(self) -> dict[str, Path]:
        """The files of the run by their endings."""
        start = len(self.base.name)
        return {path.name[start:]: path for path in sorted(self.base.parent.glob('*'))
                if path.name.startswith(self.base.name + '.')}

    def path(self, ending: str) -> Path:
        """The file with an ending, for instance '.vtkhdf'."""
        path = self.base.with_name(self.base.name + ending)
        if not path.exists():
            raise FileNotFoundError(f'there is no file {path}; this run has '
                                    + (', '.join(self.files) or 'none at all'))
        return path

    def table(self, ending: str) -> pd.DataFrame:
        """A table by its ending: .rea, .con, .his, .pts, .rig, .sen (doc/manual, "Files written")."""
        from mfec_post.tables import read_table
        return frame(read_table(str(self.path(ending))))

    @cached_property
    def reactions(self) -> pd.DataFrame:
        """The reaction table: step, time, set, R1, R2, R3."""
        return self.table('.rea')

    @cached_property
    def contact(self) -> pd.DataFrame:
        """The contact table: step, time, pair, active, stick, slip, Fn, Ft, ..."""
        return self.table('.con')

    @cached_property
    def history(self) -> pd.DataFrame:
        """Displacements that HISTory asks for."""
        return self.table('.his')

    @cached_property
    def sensitivities(self) -> pd.DataFrame:
        """Derivatives that SENSitivity or `sens` ask for."""
        return self.table('.sen')

    @property
    def log(self) -> str:
        """The log."""
        return self.path('.log').read_text(encoding='utf-8', errors='replace')

    def open(self) -> Results:
        """The results file, for everything that is in it; to be closed, or used by `with`."""
        from mfec_post.results import Results
        return Results(str(self.path('.vtkhdf')))

    @cached_property
    def times(self) -> NDArray:
        """The output times that fields were written at."""
        with self.open() as results:
            return results.times

    @cached_property
    def points(self) -> NDArray:
        """Reference coordinates of the nodes (points, 3)."""
        with self.open() as results:
            return results.points

    @cached_property
    def cells(self) -> NDArray:
        """Corners of the tetrahedra, places in `points` (cells, 4)."""
        with self.open() as results:
            return results.cells

    def field(self, name: str, step: int = -1) -> NDArray:
        """A field of nodes or cells at an output time with fields, counted from 0; -1 is the last."""
        with self.open() as results:
            if name in results.vtk['PointData']:
                return results.point_field(name, step)
            if name in (*results.vtk['CellData'], 'von_mises'):
                return results.cell_field(name, step)
        raise KeyError(f'the results have no field {name}; they have: ' + ', '.join(self.fields()))

    def fields(self) -> list[str]:
        """Names of the fields."""
        with self.open() as results:
            return sorted({*results.vtk['PointData'], *results.vtk['CellData']})

    def surface(self, pair: str, side: str = 'slave', step: int = -1) -> Surface:
        """One side of a contact pair: pressure, traction, gap, status, slip at nodes and facets."""
        from mfec_post.surfaces import Surfaces
        with Surfaces(str(self.path('.contact.vtkhdf'))) as surfaces:
            return surfaces.surface(pair, side, step)

    @cached_property
    def audit(self) -> pd.DataFrame:
        """The audit: a row for each output time and check, with verdict, value and finding."""
        rows = [{'step': record['step'], 'time': record['time'], 'check': check['name'],
                 **{name: check[name] for name in ('verdict', 'value', 'finding')}}
                for record in self.of('audit') for check in record['checks']]
        return frame(rows, ['step', 'time', 'check', 'verdict', 'value', 'finding'])

    @property
    def verdict(self) -> str:
        """The worst of the audit: ok, warning or failed; '' if there was none."""
        found = {record['verdict'] for record in self.of('audit')}
        return next((word for word in ('failed', 'warning', 'ok') if word in found), '')

    def _frame(self, event: str) -> pd.DataFrame:
        return frame(self.of(event)).drop(columns='event', errors='ignore')

    @cached_property
    def iterations(self) -> pd.DataFrame:
        """Each linear solve: step, time, residual, contact points that stick and slip, seconds."""
        return self._frame('iteration')

    @cached_property
    def steps(self) -> pd.DataFrame:
        """Each output time: step, time, solves, seconds."""
        return self._frame('end_time')

    @cached_property
    def costs(self) -> pd.DataFrame:
        """The cost table: how often each kind of work was done, and how long it took."""
        found = self.of('costs')
        return frame(found[-1]['costs'] if found else [], ['name', 'count', 'seconds'])

    @property
    def warnings(self) -> list[str]:
        """What deserves a look."""
        return [str(record['text']).removeprefix('warning: ') for record in self.of('warning')]

    @property
    def seconds(self) -> float:
        """Wall-clock time of the run."""
        found = self.of('costs')
        return float(found[-1]['seconds']) if found else float('nan')
