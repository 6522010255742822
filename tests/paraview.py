"""Which of its readers ParaView takes for a file. It goes by the name, before it looks inside.

The rule is that of vtkSMReaderFactory (Remoting/ServerManager): all runs of parts between the dots behind
the first one, compared without regard to case with the extensions of each reader's hint. The table
has the readers of HDF5 files in Remoting/Application/Resources/readers_*.xml, by the release since
which they have the extension.
"""
import os

READERS = {
    'VTKHDF': {'hdf': (5, 10), 'hdf.series': (5, 10), 'vtkhdf': (5, 12), 'vtkhdf.series': (5, 12)},
    'Truchas': {'hdf5': (5, 9), 'h5': (5, 9)},
    'VeraOut': {'h5': (5, 9)},
    'Converge': {'h5': (5, 9)},
    'Fluent CFF': {'cas.h5': (5, 12)},
}


def extensions(path):
    """What ParaView looks up for a name: of a.b.c these are c, b.c and b."""
    parts = [part for part in os.path.basename(path).split('.')[1:] if part]
    return ['.'.join(parts[first:last + 1]).lower() for last in reversed(range(len(parts)))
            for first in reversed(range(last + 1))]


def readers(path, release):
    """The readers that a release of ParaView asks whether they can read a file of this name."""
    return [name for name, known in READERS.items()
            if any(known.get(extension, (99,)) <= release for extension in extensions(path))]
