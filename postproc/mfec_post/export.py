"""Results for other programs: VTU and PVD for ParaView before 5.12, CSV for tables."""
from __future__ import annotations

import base64
import csv
import os
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .results import results_path
from .tables import read_table

TYPES = {'f8': 'Float64', 'f4': 'Float32', 'i4': 'Int32', 'i8': 'Int64', 'u1': 'UInt8'}


def array(name: str, values: NDArray) -> str:
    """A data array of a VTU file, base64 with a 64-bit length."""
    values = np.ascontiguousarray(values)
    kind = TYPES[values.dtype.str[1:]]
    data = values.astype(values.dtype.newbyteorder('<')).tobytes()
    text = base64.b64encode(np.uint64(len(data)).tobytes() + data).decode('ascii')
    components = values.shape[1] if values.ndim > 1 else 1
    return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" '
            f'format="binary">{text}</DataArray>\n')


def fields(vtk: Any, group: str, frame: int, count: int) -> str:
    """All fields of points or cells at one output time."""
    text = ''
    for name, data in vtk[group].items():
        first = int(vtk['Steps'][group + 'Offsets'][name][frame])
        text += array(name, data[first:first + count])
    return f'<{group}>\n{text}</{group}>\n'


def write_vtu(vtk: Any, frame: int, path: str) -> None:
    """One output time of a grid as a VTU file."""
    points, cells = int(vtk['NumberOfPoints'][0]), int(vtk['NumberOfCells'][0])
    with open(path, 'w', encoding='ascii') as stream:
        stream.write('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
                     'byte_order="LittleEndian" header_type="UInt64">\n<UnstructuredGrid>\n'
                     f'<Piece NumberOfPoints="{points}" NumberOfCells="{cells}">\n')
        stream.write('<Points>\n' + array('Points', vtk['Points'][:]) + '</Points>\n<Cells>\n')
        stream.write(array('connectivity', vtk['Connectivity'][:]))
        stream.write(array('offsets', vtk['Offsets'][:][1:]))
        stream.write(array('types', vtk['Types'][:]) + '</Cells>\n')
        stream.write(fields(vtk, 'PointData', frame, points))
        stream.write(fields(vtk, 'CellData', frame, cells))
        stream.write('</Piece>\n</UnstructuredGrid>\n</VTKFile>\n')


def export_grid(path: str, folder: str, name: str) -> list[str]:
    """All output times of a VTKHDF file as VTU files, and a PVD file that lists them."""
    written = []
    with h5py.File(path, 'r') as file:
        vtk = file['VTKHDF']
        steps = int(vtk['Steps'].attrs['NSteps'])
        lines = []
        for frame in range(steps):
            part = f'{name}_{frame + 1:04d}.vtu'
            write_vtu(vtk, frame, os.path.join(folder, part))
            lines.append(f'<DataSet timestep="{float(vtk["Steps/Values"][frame]):.12g}" '
                         f'file="{part}"/>\n')
            written.append(os.path.join(folder, part))
    index = os.path.join(folder, name + '.pvd')
    with open(index, 'w', encoding='ascii') as stream:
        stream.write('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n'
                     '<Collection>\n' + ''.join(lines) + '</Collection>\n</VTKFile>\n')
    return [index] + written


def export_table(path: str, folder: str) -> str:
    """A table as CSV."""
    table = read_table(path)
    out = os.path.join(folder, os.path.basename(path) + '.csv')
    with open(out, 'w', encoding='utf-8', newline='') as stream:
        writer = csv.writer(stream)
        writer.writerow(table.dtype.names or ())
        for row in table:
            writer.writerow([repr(float(v)) if isinstance(v, np.floating) else v for v in row])
    return out


def export(path: str, folder: str, grids: bool = True, tables: bool = True) -> list[str]:
    """Everything of a run: bodies, contact surfaces, tables."""
    base = os.path.splitext(path)[0]
    name = os.path.basename(base)
    os.makedirs(folder, exist_ok=True)
    written = []
    if grids:
        written += export_grid(results_path(path), folder, name)
        if os.path.exists(base + '.contact.vtkhdf'):
            written += export_grid(base + '.contact.vtkhdf', folder, name + '.contact')
    for ending in ('.rea', '.con', '.his', '.pts', '.rig') if tables else ():
        if os.path.exists(base + ending):
            written.append(export_table(base + ending, folder))
    return written
