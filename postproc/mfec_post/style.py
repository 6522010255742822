"""The look that all figures share."""
from typing import Any

import matplotlib

matplotlib.use('Agg')

INK = '#222222'
GRID = '#dddddd'
# Okabe and Ito: told apart by colour-blind readers and in print.
BLUE, ORANGE, GREEN, RED, GREY = '#0072b2', '#e69f00', '#009e73', '#d55e00', '#777777'

SETTINGS: Any = {
    'font.family': 'DejaVu Sans',
    'font.size': 9,
    'axes.edgecolor': INK,
    'axes.labelcolor': INK,
    'axes.linewidth': 0.8,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.grid': True,
    'axes.axisbelow': True,
    'grid.color': GRID,
    'grid.linewidth': 0.6,
    'xtick.color': INK,
    'ytick.color': INK,
    'text.color': INK,
    'lines.linewidth': 1.6,
    'savefig.dpi': 300,
    'savefig.bbox': 'tight',
    'legend.frameon': False,
}


def use() -> None:
    """Our settings from here on."""
    matplotlib.rcParams.update(SETTINGS)


def pyplot() -> Any:
    """matplotlib.pyplot with our settings, drawing to files."""
    import matplotlib.pyplot as plt
    use()
    return plt
