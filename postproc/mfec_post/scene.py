"""What a picture shows: facets with values at nodes or facets, exact tools, lay and friction."""
from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .geometry import exterior_facets, facet_normals, facet_size, facets_across, mid_nodes
from .results import Results, mises
from .surfaces import Surface, Surfaces, surfaces_beside

STATUS_NAMES = ('off', 'open', 'stick', 'slip')
STATUS_COLOURS = ('#e8e8e8', '#b8b8b8', style.BLUE, style.RED)
REGION_COLOURS = ('#8fbfdc', '#f2cf8a', '#8fd0b8', '#e6a583', '#c9b3d9', '#c8c8c8')
STRESSES = ('xx', 'yy', 'zz', 'xy', 'yz', 'zx')
LABELS = {'mises': 'von Mises stress', 'nodal_von_mises': 'von Mises stress',
          'pressure': 'pressure', 'pair pressure': 'contact pressure'}
SUPERSCRIPTS = str.maketrans('0123456789-', '⁰¹²³⁴⁵⁶⁷⁸⁹⁻')
FEW = 8
"""Contact is called under-resolved with fewer facets across it."""
FRONT = (-60.0, 24.0)


@dataclass
class Scene:
    """Facets with values, lines and arrows on them, and what the colours mean."""
    points: NDArray
    facets: NDArray
    values: NDArray
    """A value for each point, or one for each facet."""
    label: str
    title: str = ''
    mids: NDArray = field(default_factory=lambda: np.zeros((0, 3), dtype=int))
    """Mid nodes of the edges, -1 where there is none; empty where all facets are flat."""
    limits: Optional[tuple[float, float]] = None
    view: tuple[float, float] = FRONT
    note: str = ''
    tools: list[tuple[NDArray, NDArray]] = field(default_factory=list)
    """Exact tools: points and facets."""
    strokes: list[tuple[NDArray, NDArray]] = field(default_factory=list)
    """Lay: places, and vectors of length 1."""
    arrows: list[tuple[NDArray, NDArray]] = field(default_factory=list)
    """Shear tractions: places, and vectors."""
    is_surface: bool = False
    """A contact surface: its colours are not shaded."""
    is_closed: bool = False
    """Facets that are seen from within their body are left out, so that one looks into a bore."""
    names: tuple[str, ...] = ()
    """What the values mean where they are kinds: the first is `first`, the next one more."""
    first: int = 0
    """The value of the first name."""
    colours: tuple[str, ...] = ()
    """The colours of the names."""

    @property
    def at_facets(self) -> bool:
        """Whether a value belongs to a facet, not to a node."""
        return len(self.values) == len(self.facets) and len(self.values) != len(self.points)

    @property
    def size(self) -> float:
        """Length of a facet."""
        return facet_size(self.points, self.facets)


@dataclass
class Units:
    """The units of the deck, for labels; mfec itself knows none."""
    length: str = ''
    force: str = ''

    def label(self, name: str, unit: str) -> str:
        """A name and its unit: pressure (N/mm²)."""
        if unit in ('', '1'):
            return name
        for word, given in (('length', self.length), ('force', self.force)):
            unit = unit.replace(word, given or word)
        base, *powers = unit.split('^')
        text = base + ''.join(p[0].translate(SUPERSCRIPTS) + p[1:] for p in powers)
        return f'{name} ({text})'


def named(name: str) -> str:
    """What a field is called in a picture."""
    return LABELS.get(name, f'stress {name}' if name in STRESSES else name.replace('_', ' '))


def bodies(results: Results, frame: int = -1, name: str = 'mises', scale: float = 1.0,
           view: Optional[tuple[float, float]] = None, units: Optional[Units] = None) -> Scene:
    """The outer facets of all bodies, displaced `scale` times, coloured by a field; exact tools."""
    index = results.index(frame)
    x = results.points
    faces, owner = exterior_facets(results.cells, x)
    if 'displacement' in results.vtk['PointData']:
        x = x + scale * results.point_field('displacement', index)
    values, label, unit = body_values(results, index, name, owner)
    title = f'time {results.times[index]:g}'
    if scale != 1.0:
        title += f', displacements {scale:g} times'
    return Scene(x, faces, values, (units or Units()).label(label, unit), title,
                 mid_nodes(faces, results.ten_node_cells), view=view or FRONT,
                 tools=exact_tools(results, index, scale))


def exact_tools(results: Results, index: int, scale: float) -> list[tuple[NDArray, NDArray]]:
    """The surfaces of exact tools: those of the file of surfaces whose nodes no body has."""
    path = surfaces_beside(results.path)
    found: list[tuple[NDArray, NDArray]] = []
    if not results.pairs or not os.path.exists(path):
        return found
    of_bodies = results.node_numbers[np.unique(results.cells)]
    with Surfaces(path) as surfaces:
        for pair in surfaces.pairs:
            part = surfaces.surface(pair, 'master', index)
            if len(part.facets) and not np.any(np.isin(part.nodes, of_bodies)):
                found.append((part.points + scale * part.at_nodes['displacement'], part.facets))
    return found


def mesh(results: Results, view: Optional[tuple[float, float]] = None) -> Scene:
    """The mesh before the run, a colour for each region."""
    x = results.points
    faces, owner = exterior_facets(results.cells, x)
    number, names = results.regions()
    used = [k for k in range(len(names)) if np.any(number[owner] == k + 1)]
    values = np.searchsorted(used, number[owner] - 1).astype(float)
    return Scene(x, faces, values, 'region', 'mesh', mid_nodes(faces, results.ten_node_cells),
                 view=view or FRONT, names=tuple(names[k] for k in used),
                 colours=tuple(REGION_COLOURS[k % len(REGION_COLOURS)] for k in range(len(used))),
                 tools=exact_tools(results, 0, 0.0) if results.steps else [])


def body_values(results: Results, index: int, name: str,
                owner: NDArray) -> tuple[NDArray, str, str]:
    """A field at the points or on the outer facets, what it is called, and its unit."""
    points, cells = results.vtk['PointData'], results.vtk['CellData']
    if name in ('mises', 'pressure') + STRESSES and 'stress' in cells:
        stress = nodal_stress(results, index)
        if name == 'mises':
            values = mises(stress)
        elif name == 'pressure':
            values = -stress[:, :3].mean(axis=1)
        else:
            values = stress[:, STRESSES.index(name)]
        return values, named(name), results.unit('stress')
    if name in points:
        return lengths(results.point_field(name, index) if points[name].dtype.kind == 'f'
                       else points[name][:].astype(float)), named(name), results.unit(name)
    if name in cells:
        values = (results.cell_field(name, index) if cells[name].dtype.kind == 'f'
                  else cells[name][:].astype(float))
        return lengths(values)[owner], named(name) + ', by element', results.unit(name)
    known = sorted(set(points) | set(cells)
                   | (set(('mises', 'pressure') + STRESSES) if 'stress' in cells else set()))
    raise KeyError(f'{results.path} has no field {name}; it has: ' + ', '.join(known))


def nodal_stress(results: Results, index: int) -> NDArray:
    """Stresses at the points: those of the file, or means of the cells around each."""
    if 'nodal_stress' in results.vtk['PointData']:
        return results.point_field('nodal_stress', index)
    stress, cells = results.cell_field('stress', index), results.cells
    total, number = np.zeros((len(results.points), 6)), np.zeros(len(results.points))
    np.add.at(total, cells.ravel(), np.repeat(stress, 4, axis=0))
    np.add.at(number, cells.ravel(), 1.0)
    mids = results.ten_node_cells[:, 4:]
    if len(mids):
        curved = stress[results.vtk['Types'][:] == 24]
        np.add.at(total, mids.ravel(), np.repeat(curved, 6, axis=0))
        np.add.at(number, mids.ravel(), 1.0)
    return total / np.maximum(number, 1.0)[:, None]


def lengths(values: NDArray) -> NDArray:
    """Vectors become their lengths, numbers stay."""
    return np.linalg.norm(values, axis=1) if values.ndim == 2 else values


def contact(surfaces: Surfaces, frame: int = -1, name: str = 'pressure',
            pairs: Optional[list[str]] = None, side: str = 'slave', scale: float = 1.0,
            view: Optional[tuple[float, float]] = None, units: Optional[Units] = None,
            by_facet: bool = False) -> Scene:
    """One side of some pairs (all without a list), coloured by a field, with lay and friction."""
    parts = [surfaces.surface(pair, side, frame) for pair in pairs or list(surfaces.pairs)]
    if not parts or sum(len(part.facets) for part in parts) == 0:
        raise KeyError(f'{surfaces.path} has no facets on the {side} side')
    for part in parts:
        if name not in part.at_nodes:
            raise KeyError(f'{surfaces.path} has no field {name}; it has: '
                           + ', '.join(part.at_nodes))
    by_facet = by_facet or name == 'status'
    starts = np.cumsum([0] + [len(part.points) for part in parts])
    places = [part.points + scale * part.at_nodes['displacement'] for part in parts]
    f = np.concatenate([part.facets + start for part, start in zip(parts, starts)])
    mids = np.concatenate([np.where(part.mids < 0, -1, part.mids + start)
                           for part, start in zip(parts, starts)])
    values = np.concatenate([lengths((part.at_facets if by_facet else part.at_nodes)[name])
                             for part in parts])
    if len(parts) > 1:
        kept = once(parts)
        f, mids = f[kept], mids[kept]
        values = values[kept] if by_facet else values
    index = frame + surfaces.steps if frame < 0 else frame
    label = named('pair pressure' if name == 'pressure' else name) + ', by facet' * by_facet
    scene = Scene(np.concatenate(places), f, values,
                  (units or Units()).label(label, surfaces.unit(name)),
                  f'{", ".join(pairs or list(surfaces.pairs))}: {side} side, time '
                  f'{surfaces.times[index]:g}', mids, is_surface=True, note=resolution(parts))
    if name == 'status':
        scene.names, scene.first, scene.colours = STATUS_NAMES, -1, STATUS_COLOURS
    if name == 'lay':  # its strokes say all
        scene.names, scene.colours, scene.values = ('surface',), ('#d5dbe1',), np.zeros(len(f))
    pressed = np.concatenate([np.nan_to_num(part.at_nodes['pressure']) for part in parts])
    scene.view, scene.is_closed = view_of(scene, side, pressed[f].mean(axis=1))
    scene.view = view or scene.view
    largest = max(np.abs(np.nan_to_num(part.at_nodes['traction'])).max() for part in parts)
    for part, place in zip(parts, places):
        shear = np.nan_to_num(part.at_nodes['shear_traction'])
        scene.strokes.append((place, part.at_nodes['lay']))
        if np.abs(shear).max() > 1e-6 * largest:  # more than round-off
            scene.arrows.append((place, shear))
    return scene


def resolution(parts: list[Surface]) -> str:
    """A note where a pair touches over few facets only: those whose corners are all pressed."""
    across = []
    for part in parts:
        pressed = np.nan_to_num(part.at_nodes['pressure']) > 0.0
        if np.any(pressed):
            across.append(facets_across(part.facets, np.all(pressed[part.facets], axis=1)))
    if not across or min(across) >= FEW:
        return ''
    if min(across) == 0:
        return 'under-resolved: no facet with all its corners in contact'
    return (f'under-resolved: {min(across)} facet{"s" * (min(across) > 1)} across the contact, '
            f'{FEW} are wanted')


def once(parts: list[Surface]) -> NDArray:
    """Places of the facets of all parts without those that lie twice: a surface in two pairs is seen
    with the larger force."""
    nodes = np.sort(np.concatenate([part.nodes[part.facets] for part in parts]), axis=1)
    force = np.concatenate([lengths(np.nan_to_num(part.at_facets['traction'])) for part in parts])
    order = np.lexsort((-force, *nodes.T))
    first = np.append(True, np.any(np.diff(nodes[order], axis=0) != 0, axis=1))
    return np.sort(order[first])


def view_of(scene: Scene, side: str, pressed: NDArray) -> tuple[tuple[float, float], bool]:
    """From where one looks onto a contact surface, and whether its far half alone is drawn.

    A bore, or a shaft, that goes all around is seen from outside without the facets that turn
    their backs, towards those that are pressed most (a weight for each facet). A surface that is
    open is seen along its mean normal, a bent one from the right and from above: a hollow one from
    where it is hollow, others as if the master's eyes were closed and the slave were made of glass.
    """
    normals = facet_normals(scene.points, scene.facets)
    total, area = normals.sum(axis=0), np.linalg.norm(normals, axis=1).sum()
    if np.linalg.norm(total) < 0.3 * area:
        normal = np.maximum(pressed, 0.0) @ normals
        if np.linalg.norm(normal[:2]) <= 0.3 * (np.abs(pressed) @ np.linalg.norm(normals, axis=1)):
            return FRONT, True
        return (float(np.degrees(np.arctan2(normal[1], normal[0]))) + 20.0, FRONT[1]), True
    centres = scene.points[scene.facets].mean(axis=1)
    middle = np.average(centres, axis=0, weights=np.linalg.norm(normals, axis=1))
    is_hollow = np.einsum('ij,ij->', normals, centres - middle) < -0.02 * area * np.ptp(
        centres, axis=0).max()
    normal = total / np.linalg.norm(total) * (-1.0 if side == 'slave' and not is_hollow else 1.0)
    if abs(normal[2]) > 0.9:  # x to the right, y upwards
        return (-90.0, 90.0), False
    azimuth = np.degrees(np.arctan2(normal[1], normal[0]))
    elevation = np.degrees(np.arcsin(np.clip(normal[2], -1, 1)))
    if np.linalg.norm(total) < 0.95 * area:
        return (float(azimuth) + 25.0, float(min(elevation + 20.0, 80.0))), False
    return (float(azimuth), float(elevation)), False


def colour_limits(scene: Scene) -> tuple[float, float]:
    """The ends of the scale of colours."""
    if scene.names:
        return scene.first - 0.5, scene.first + len(scene.names) - 0.5
    if scene.limits:
        return scene.limits
    low, high = value_range(scene, 0.5)
    spread = max(abs(low), abs(high), 1e-300)
    low = 0.0 if 0.0 < low < 0.02 * high else low
    return (low, high) if high - low > 1e-6 * spread else (low - 0.5 * spread, high + 0.5 * spread)


def value_range(scene: Scene, beyond: float = 0.0) -> tuple[float, float]:
    """Least and largest value of what is drawn; `beyond` per cent of them lie outside at each end."""
    values = scene.values if scene.at_facets else scene.values[seen_nodes(scene)]
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return 0.0, 1.0
    low, high = np.percentile(values, [beyond, 100.0 - beyond])
    return float(low), float(high)


def seen_nodes(scene: Scene) -> NDArray:
    """The nodes of the facets."""
    nodes = np.unique(np.append(scene.facets, scene.mids))
    return nodes[nodes >= 0]
