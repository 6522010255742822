"""The program that does the work: inside this package, named by MFEC_PROGRAM, or of the path."""
from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Optional

HERE = Path(__file__).resolve().parent


def find_program(program: Optional[str] = None) -> str:
    """Path of the program: `program`, else $MFEC_PROGRAM, the wheel's own, ./mfec of the sources, or
    `mfec` of the path."""
    wanted = program or os.environ.get('MFEC_PROGRAM')
    if wanted:
        found = shutil.which(wanted)
        if not found:
            raise FileNotFoundError(f'there is no program {wanted}')
        return os.path.abspath(found)
    for place in (HERE / 'bin' / 'mfec', HERE.parent.parent / 'mfec'):
        if place.is_file() and os.access(place, os.X_OK):
            return str(place)
    for folder in os.get_exec_path():  # not this package's own command, which would call itself
        place = Path(folder) / 'mfec'
        if place.is_file() and os.access(place, os.X_OK) and not is_script(place):
            return str(place)
    raise FileNotFoundError('there is no program mfec: pip install the wheel that brings it, put mfec '
                            'into the path, or name it by MFEC_PROGRAM')


def is_script(path: Path) -> bool:
    """Whether a file begins with #!."""
    with open(path, 'rb') as stream:
        return stream.read(2) == b'#!'


def program_version(program: Optional[str] = None) -> str:
    """The version that the program says, for instance '1.0.0'."""
    done = subprocess.run([find_program(program), '--version'], capture_output=True, text=True,
                          check=True)
    return done.stdout.split('\n', maxsplit=1)[0].split()[1]


def main() -> None:
    """The command `mfec` of the wheel: the program takes the place of Python."""
    try:
        path = find_program()
    except FileNotFoundError as problem:
        sys.exit(f'mfec: {problem}')
    os.execv(path, [path, *sys.argv[1:]])
