"""Reading, comparing and drawing what mfec writes.

    from mfec_post import read_table, Results
    rea = read_table('demo/mfc_0.1/sliding_cube.rea')
    top = rea[rea['set'] == 'top']
    with Results('demo/mfc_0.1/sliding_cube.vtkhdf') as run:
        u = run.set_displacement('top')
"""
from .results import Results
from .surfaces import Surface, Surfaces
from .tables import TableError, read_table, rows_of

__all__ = ['Results', 'Surface', 'Surfaces', 'TableError', 'read_table', 'rows_of']
