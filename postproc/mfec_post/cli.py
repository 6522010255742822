"""The command mfec-post: report, plot, picture, movie, compare, export, identify, check, adapt, watch."""
from __future__ import annotations

import argparse
import os
import sys
from typing import Optional

import mfec

from . import adapt, check, compare, demo, drawing, export, identify, pictures, plots, report, watch
from .tables import TableError


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = argparse.ArgumentParser(prog='mfec-post', description='Reads, draws, compares and '
                                  'exports what mfec writes.')
    commands = top.add_subparsers(dest='command', required=True)
    one = commands.add_parser('report', help='one HTML file of a run')
    one.add_argument('results', help='results file (.vtkhdf); log and tables lie beside it')
    one.add_argument('--out', help='file to write (default: x.html)')
    one = commands.add_parser('plot', help='curves of any columns of any tables')
    one.add_argument('tables', nargs='+', help='.rea, .con, .his, ... of one or several runs')
    one.add_argument('--x', default='time', help='column along the axis (default time)')
    one.add_argument('--y', nargs='+', default=[], help='columns, or quotients: Ft/Fn')
    one.add_argument('--name', action='append', help='set or pair; all without it')
    one.add_argument('--title', default='')
    one.add_argument('--out', default='plot.png', help='picture (.png, .pdf, .svg)')
    one = commands.add_parser('picture', help='bodies or contact surfaces at one output time')
    pictures.add_options(one)
    one.add_argument('--frame', type=int, default=-1, help='output time, from 0 (default: last)')
    one.add_argument('--out', default='picture.png', help='picture (.png; words of .pdf '
                     'and .svg are vectors)')
    one.add_argument('--dpi', type=float, default=drawing.DPI, help='pixels an inch (default 300)')
    one = commands.add_parser('movie', help='the same for all output times')
    pictures.add_options(one)
    one.add_argument('--dpi', type=float, default=150.0, help='pixels an inch (default 150)')
    one.add_argument('--fps', type=float, default=8.0, help='pictures a second')
    one.add_argument('--out', default='movie.gif', help='.gif or .mp4')
    one = commands.add_parser('compare', help='two tables with tolerances', add_help=False)
    one.add_argument('rest', nargs=argparse.REMAINDER)
    one = commands.add_parser('export', help='VTU and PVD for older ParaView, CSV for tables')
    one.add_argument('results', help='results file (.vtkhdf)')
    one.add_argument('--out', help='folder (default: x_export)')
    one.add_argument('--csv', action='store_true', help='tables only')
    one.add_argument('--vtu', action='store_true', help='grids only')
    one = commands.add_parser('demo', help="the paper's example: five runs, their figure and table")
    one.add_argument('--out', default='demo', help='folder (default demo)')
    one = commands.add_parser('examples', help='copies the example decks, or one of them')
    one.add_argument('name', nargs='?', help='for instance sliding_cube (default: all)')
    one.add_argument('--out', default='mfec_examples', help='folder (default mfec_examples)')
    one = commands.add_parser('identify', help='friction from measured curves; --plan: what a '
                              'path would tell')
    identify.add_options(one)
    one = commands.add_parser('check', help='proves a result from its file alone')
    check.add_options(one)
    one = commands.add_parser('adapt', help='a number with its error: runs, estimates and remeshes '
                              'until it is small enough')
    adapt.add_options(one)
    one = commands.add_parser('watch', help='residual and reactions of a run while it goes on')
    watch.add_options(one)
    return top


def perform(given: argparse.Namespace) -> list[str]:
    """Carries out a command; the files written."""
    if given.command == 'report':
        out = given.out or os.path.splitext(given.results)[0] + '.html'
        return [report.write(given.results, out)]
    if given.command == 'plot':
        plots.plot(plots.curves(given.tables, given.x, given.y, given.name), given.out, given.x,
                   given.title)
        return [given.out]
    if given.command == 'examples':
        if given.name is None:
            return [str(mfec.copy_examples(given.out))]
        os.makedirs(given.out, exist_ok=True)
        return [str(mfec.Deck.read(mfec.example(given.name)).write(
            os.path.join(given.out, os.path.basename(given.name) + '.inp')))]
    if given.command == 'picture':
        return [pictures.picture(given)]
    if given.command == 'movie':
        return [pictures.movie(given, pictures.to_terminal)]
    out = given.out or os.path.splitext(given.results)[0] + '_export'
    both = given.csv == given.vtu
    return export.export(given.results, out, both or given.vtu, both or given.csv)


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit code 0: done; 2: not to be done. `compare` has its own: 1 where tables differ."""
    words = sys.argv[1:] if arguments is None else arguments
    if words[:1] == ['compare']:
        return compare.main(words[1:])
    given = parser().parse_args(words)
    if given.command == 'identify':
        return identify.main(given)
    if given.command == 'check':
        return check.main(given)
    if given.command == 'adapt':
        return adapt.main(given)
    try:
        if given.command == 'watch':
            return watch.main(given)
        if given.command == 'demo':
            return demo.main(['--program', mfec.find_program(), '--deck',
                              str(mfec.example('sliding_cube')), '--out', given.out])
        written = perform(given)
    except (OSError, KeyError, IndexError, TableError) as problem:
        text = problem.args[0] if isinstance(problem, KeyError) else problem
        print(f'mfec-post {given.command}: {text}', file=sys.stderr)
        return 2
    for path in written:
        print(path)
    return 0


if __name__ == '__main__':
    sys.exit(main())
