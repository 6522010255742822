"""The example decks that come along."""
from __future__ import annotations

import shutil
from os import PathLike
from pathlib import Path

HERE = Path(__file__).resolve().parent
PLACES = (HERE / 'examples', HERE.parent.parent / 'inputs', Path('/usr/share/doc/mfec/inputs'))


def folder() -> Path:
    """Where they lie."""
    for place in PLACES:
        if place.is_dir():
            return place
    raise FileNotFoundError('no example decks came with this installation; they are the folder inputs '
                            'of the sources')


def examples() -> list[str]:
    """Their names, for `example`."""
    top = folder()
    return sorted(str(path.relative_to(top).with_suffix('')) for path in top.rglob('*.inp'))


def example(name: str) -> Path:
    """Path of an example deck: `example('sliding_cube')`."""
    path = folder() / (name + '.inp')
    if not path.is_file():
        raise FileNotFoundError(f'there is no example {name}; there are: ' + ', '.join(examples()))
    return path


def copy_examples(out: str | PathLike[str] = 'mfec_examples') -> Path:
    """Copies all of them, with their meshes, to a folder that is not there yet; its path."""
    return Path(shutil.copytree(folder(), out))
