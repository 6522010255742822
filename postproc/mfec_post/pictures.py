"""Pictures and movies of the bodies, or of the surfaces of contact."""
from __future__ import annotations

import argparse
import sys
from typing import Callable, Optional

import numpy as np
from numpy.typing import NDArray

from . import drawing
from . import scene as scenes
from .results import Results
from .surfaces import Surfaces, surfaces_beside


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options that pictures and movies share."""
    parser.add_argument('results', help='results file (.vtkhdf); x.contact.vtkhdf lies beside it')
    parser.add_argument('--field', default='mises', help='colours the bodies: mises, pressure, '
                        'displacement, xx .. zx, or any field of the file')
    parser.add_argument('--contact', metavar='FIELD', help='shows the surfaces of contact instead, '
                        'coloured by pressure, gap, status, slip, ...')
    parser.add_argument('--pair', action='append', help='pair of --contact; all without it')
    parser.add_argument('--side', choices=('slave', 'master'), default='slave')
    parser.add_argument('--scale', type=float, default=1.0, help='magnifies the displacements')
    parser.add_argument('--view', type=float, nargs=2, metavar=('AZIMUTH', 'ELEVATION'))
    parser.add_argument('--by-facet', action='store_true', help='--contact: means of facets in '
                        'place of the field of the nodes')
    parser.add_argument('--length', default='', metavar='UNIT', help='for labels: mm')
    parser.add_argument('--force', default='', metavar='UNIT', help='for labels: N')
    parser.add_argument('--size', type=float, nargs=2, default=drawing.SIZE, metavar=('W', 'H'),
                        help='in print [mm] (default %g %g)' % drawing.SIZE)


class Maker:
    """Makes the scenes of a run as the options say."""

    def __init__(self, given: argparse.Namespace):
        self.given = given
        self.view = tuple(given.view) if given.view else None
        self.units = scenes.Units(given.length, given.force)
        self.file = Surfaces(surfaces_beside(given.results)) if given.contact \
            else Results(given.results)
        self.steps = self.file.steps

    def __call__(self, frame: int) -> scenes.Scene:
        given = self.given
        if isinstance(self.file, Surfaces):
            return scenes.contact(self.file, frame, given.contact, given.pair, given.side,
                                  given.scale, self.view, self.units, given.by_facet)
        return scenes.bodies(self.file, frame, given.field, given.scale, self.view, self.units)


def picture(given: argparse.Namespace) -> str:
    """Draws one output time."""
    drawing.draw(Maker(given)(given.frame), given.out, tuple(given.size), given.dpi)
    return given.out


def common_limits(make: Callable[[int], scenes.Scene], steps: int) -> tuple[float, float]:
    """One scale of colours for all output times."""
    ends = [scenes.colour_limits(make(frame)) for frame in range(steps)]
    return min(low for low, _ in ends), max(high for _, high in ends)


def movie(given: argparse.Namespace, show: Optional[Callable[[str], None]] = None) -> str:
    """Draws all output times into a GIF or an MP4."""
    make = Maker(given)
    if make.steps == 0:
        raise KeyError(f'{given.results} holds no output time with fields')
    limits = common_limits(make, make.steps)
    view = make(make.steps - 1).view
    pictures = []
    for frame in range(make.steps):
        scene = make(frame)
        scene.limits, scene.view = limits, view
        pictures.append(drawing.draw(scene, None, tuple(given.size), given.dpi))
        if show:
            show(progress(frame + 1, make.steps))
    if given.out.lower().endswith('.gif'):
        write_gif(pictures, given.out, given.fps)
    else:
        write_mp4(pictures, given.out, given.fps)
    return given.out


def progress(done: int, of: int) -> str:
    """A bar for the terminal."""
    filled = round(30 * done / of)
    return '\r[' + '#' * filled + '.' * (30 - filled) + f'] {done} of {of}' + '\n' * (done == of)


def write_gif(pictures: list[NDArray], path: str, fps: float) -> None:
    """A GIF that goes round and round."""
    from PIL import Image
    images = [Image.fromarray(p).quantize(128) for p in pictures]
    images[0].save(path, save_all=True, append_images=images[1:], duration=round(1000 / fps),
                   loop=0)


def write_mp4(pictures: list[NDArray], path: str, fps: float) -> None:
    """A film that browsers and slides play, by ffmpeg."""
    try:
        import imageio_ffmpeg
    except ImportError as missing:
        raise OSError('MP4 wants ffmpeg: pip install imageio-ffmpeg, or write a .gif') from missing
    height, width = (2 * (n // 2) for n in pictures[0].shape[:2])
    writer = imageio_ffmpeg.write_frames(path, (width, height), fps=fps, macro_block_size=2)
    writer.send(None)
    for one in pictures:
        writer.send(np.ascontiguousarray(one[:height, :width]))
    writer.close()


def to_terminal(text: str) -> None:
    """Shows the bar where somebody looks."""
    if sys.stderr.isatty():
        sys.stderr.write(text)
        sys.stderr.flush()
