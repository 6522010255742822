"""Sizes that spread the error evenly, and meshes of these sizes: by gmsh from a geometry, by mmg from
a mesh alone."""
from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from .adapt_model import EDGES, Bodies, facets_of, lowered

COARSER, FINER = 1.6, 3.0
"""A size changes by these factors at most from one mesh to the next."""
GRADIENT = 0.35
"""Largest change of the size along an edge, over its length."""
CORNERS = EDGES.tolist()


class MeshError(Exception):
    """A mesher that does not do what it is asked for, in words for the user."""


def wanted_sizes(bodies: Bodies, eta: NDArray, factor: float) -> NDArray:
    """Size at each corner node for `factor` times the cells (doc/theory, eq. (13.12)); the squared
    errors eta of cells of rigid bodies are 0: these keep theirs."""
    h, p = bodies.sizes, bodies.order
    elastic = np.array([not bodies.materials[int(m)].rigid for m in bodies.material])
    density = np.maximum(eta / bodies.volumes, 1e-30 * (eta / bodies.volumes).max() + 1e-300)
    shape = np.where(elastic, (density / h ** (2 * p)) ** (-1.0 / (2 * p + 3)), h)

    def sizes(scale: float) -> NDArray:
        return np.where(elastic, np.clip(scale * shape, h / FINER, COARSER * h), h)

    low, high = np.log((h / shape)[elastic].min() / 10), np.log((h / shape)[elastic].max() * 10)
    for _ in range(60):
        middle = 0.5 * (low + high)
        many = ((h / sizes(np.exp(middle))) ** 3)[elastic].sum() > factor * elastic.sum()
        low, high = (middle, high) if many else (low, middle)
    return graded(bodies, sizes(np.exp(high)))


def graded(bodies: Bodies, sizes: NDArray) -> NDArray:
    """Sizes of cells as sizes of nodes: geometric means, growing slowly."""
    corners = bodies.cells[:, :4]
    total, count = np.zeros(len(bodies.points)), np.zeros(len(bodies.points))
    np.add.at(total, corners.ravel(), np.repeat(np.log(sizes), 4))
    np.add.at(count, corners.ravel(), 1.0)
    return spread(bodies, np.exp(total / np.maximum(count, 1.0)))


def spread(bodies: Bodies, h: NDArray) -> NDArray:
    """Sizes of nodes that grow no quicker than GRADIENT."""
    corners = bodies.cells[:, :4]
    edges = np.unique(np.sort(corners[:, CORNERS], axis=2).reshape(-1, 2), axis=0)
    length = np.linalg.norm(bodies.points[edges[:, 0]] - bodies.points[edges[:, 1]], axis=1)
    for _ in range(100):
        before = h.copy()
        for a, b in ((0, 1), (1, 0)):
            np.minimum.at(h, edges[:, a], before[edges[:, b]] + GRADIENT * length)
        if np.allclose(before, h, rtol=1e-6):
            break
    return h


def matched(bodies: Bodies, h: NDArray, pairs: list[tuple[str, str]]) -> NDArray:
    """No slave facet coarser than the master's at it: contact holds at the slave's points alone, and nodes of
    the master between them go through."""
    h = h.copy()
    for slave, master in pairs:
        ours, theirs = (np.unique(bodies.surfaces[name]) for name in (slave, master))
        for some in np.array_split(theirs, 1 + len(theirs) // 500):
            away = ((bodies.points[some, None] - bodies.points[ours]) ** 2).sum(-1)
            near = away.argmin(1)
            close = away[np.arange(len(some)), near] < h[ours[near]] ** 2
            np.minimum.at(h, ours[near[close]], h[some[close]])
    return spread(bodies, h)


def missing(name: str) -> MeshError:
    """What to do where a mesher is not installed."""
    return MeshError(f'{name} is not installed: pip install "mfec[adapt]"')


def mmg_program() -> str:
    """The binary mmg3d that the wheel mmgpy brings."""
    import importlib.util
    found = importlib.util.find_spec('mmgpy')
    if found is None or not found.submodule_search_locations:
        raise missing('mmgpy')
    for folder in found.submodule_search_locations:
        for name in ('mmg3d_O3', 'mmg3d_O3.exe'):
            path = os.path.join(folder, 'bin', name)
            if os.path.exists(path):
                return path
    raise MeshError('this mmgpy brings no program mmg3d: mmgpy 0.17 does')


def by_mmg(bodies: Bodies, h: NDArray, own: set[str], folder: Path) -> Bodies:
    """A mesh of four nodes a cell with sizes h, body by body; rigid ones stay as they are. Sets that
    the deck defines itself (`own`) need not survive."""
    old = lowered(bodies)
    if old is not bodies:
        h = h[np.unique(bodies.cells[:, :4])]
    corners, behind, _ = facets_of(old.cells)
    kept = {name: facets for name, facets in old.surfaces.items() if name not in own}
    sets = {name: nodes for name, nodes in old.sets.items() if name not in own}
    mask = np.zeros(len(corners), int)
    keys = np.sort(corners, axis=1)
    for bit, facets in enumerate(kept.values()):
        have = set(map(tuple, np.sort(facets, axis=1)))
        mask |= np.array([tuple(key) in have for key in keys], int) << bit
    for bit, nodes in enumerate(sets.values(), len(kept)):
        mask |= np.isin(corners, nodes).all(1).astype(int) << bit
    if len(kept) + len(sets) > 30:
        raise MeshError('more than 30 surfaces and sets of the mesh file: give a geometry by --geo')
    for name, bit in zip(sets, range(len(kept), 31)):
        if not (mask >> bit & 1).any():
            raise MeshError(f"the set '{name}' of the mesh file holds no facet, and nodes do not outlive "
                            'a new mesh: define it in the deck by PLANe or BOX, or give a geometry by --geo')
    parts = [one_body(old, members, h, corners[np.isin(behind, members)], mask[np.isin(behind, members)],
                      folder) for members in old.pieces()]
    points = np.vstack([part[0] for part in parts])
    shift = np.cumsum([0] + [len(part[0]) for part in parts[:-1]])
    cells = np.vstack([part[1] + first for part, first in zip(parts, shift)])
    group = np.concatenate([part[2] for part in parts])
    facets = np.vstack([part[3] + first for part, first in zip(parts, shift)])
    bits = np.concatenate([part[4] for part in parts])
    surfaces = {name: facets[bits >> bit & 1 > 0] for bit, name in enumerate(kept)}
    new_sets = {name: np.unique(facets[bits >> bit & 1 > 0]) for bit, name in enumerate(sets, len(kept))}
    groups = old.groups()
    return Bodies(points, cells, np.array([groups[g][0] for g in group]),
                  np.array([groups[g][1] for g in group]), old.regions, new_sets, surfaces, old.materials)


def one_body(old: Bodies, members: NDArray, h: NDArray, corners: NDArray, mask: NDArray,
             folder: Path) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
    """Points, cells, their groups, facets and their masks of one body."""
    group = np.zeros(len(old.cells), int)
    for k, (_, _, cells) in enumerate(old.groups()):
        group[cells] = k
    used = np.unique(old.cells[members])
    new = np.full(len(old.points), -1)
    new[used] = np.arange(len(used))
    body = (old.points[used], new[old.cells[members]], group[members], new[corners], mask)
    if all(old.materials[int(m)].rigid for m in old.material[members]):
        return body
    path = folder / 'body.mesh'
    write_medit(path, *body)
    size = h[used]
    (folder / 'body.sol').write_text(f'MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(size)}\n1 1\n'
                                     + '\n'.join('%.9g' % s for s in size) + '\nEnd\n', encoding='ascii')
    length = np.linalg.norm(np.ptp(body[0], axis=0))
    # mmg takes half of the machine's memory, and clears it, unless told: it needs less than 5 kB a cell
    cells = len(members) + ((old.sizes[members] / h[old.cells[members]].mean(1)) ** 3).sum()
    words = [mmg_program(), '-in', str(path), '-sol', str(folder / 'body.sol'), '-out',
             str(folder / 'new.mesh'), '-v', '0', '-m', f'{50 + 5e-3 * cells:.0f}',
             '-hausd', '%.9g' % (5e-3 * length), '-hgrad', '1.4',
             '-hmin', '%.9g' % (0.5 * size.min()), '-hmax', '%.9g' % (2.0 * size.max())]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0 or not (folder / 'new.mesh').exists():
        raise MeshError('mmg3d has failed: ' + (done.stderr or done.stdout).strip()[-300:])
    found = read_medit(folder / 'new.mesh')
    for name in ('body.mesh', 'body.sol', 'new.mesh', 'new.sol'):
        (folder / name).unlink(missing_ok=True)
    return found


def write_medit(path: Path, points: NDArray, cells: NDArray, group: NDArray, facets: NDArray,
                mask: NDArray) -> None:
    """A mesh of mmg; references begin with 1."""
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    left = np.einsum('ij,ij->i', b - a, np.cross(c - a, d - a)) < 0
    cells = np.where(left[:, None], cells[:, [1, 0, 2, 3]], cells)
    lines = ['MeshVersionFormatted 2', 'Dimension 3', 'Vertices', str(len(points))]
    lines += ['%.17g %.17g %.17g 0' % tuple(x) for x in points]
    lines += ['Tetrahedra', str(len(cells))]
    lines += ['%d %d %d %d %d' % (*(cell + 1), g + 1) for cell, g in zip(cells, group)]
    lines += ['Triangles', str(len(facets))]
    lines += ['%d %d %d %d' % (*(facet + 1), m + 1) for facet, m in zip(facets, mask)]
    path.write_text('\n'.join(lines) + '\nEnd\n', encoding='ascii')


def read_medit(path: Path) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
    """What write_medit writes, from mmg. Triangles between materials are no facets."""
    blocks, words = {}, path.read_text(encoding='ascii').split()
    width = {'Vertices': 4, 'Tetrahedra': 5, 'Triangles': 4}
    at = 0
    while at < len(words):
        if words[at] in width:
            n, w = int(words[at + 1]), width[words[at]]
            blocks[words[at]] = np.array(words[at + 2:at + 2 + n * w], float).reshape(n, w)
            at += 2 + n * w
        else:
            at += 1
    cells = blocks['Tetrahedra'].astype(int)
    facets = blocks['Triangles'].astype(int)
    used = np.unique(cells[:, :4])
    new = np.full(len(blocks['Vertices']) + 1, -1)
    new[used] = np.arange(len(used))
    corners = new[cells[:, :4]]
    outer = set(map(tuple, np.sort(facets_of(corners)[0], axis=1)))
    facet = new[facets[:, :3]]
    there = np.array([tuple(key) in outer for key in np.sort(facet, axis=1)], bool)
    return (blocks['Vertices'][used - 1, :3], corners, cells[:, 4] - 1, facet[there],
            facets[there, 3] - 1)


@dataclass
class Sag:
    """How far a round surface lies from each of its facets of six nodes, along their normals."""

    places: NDArray
    areas: NDArray
    normals: NDArray
    ways: NDArray


WITHIN = np.array([[1, 1, 1], [4, 1, 1], [1, 4, 1], [1, 1, 4], [5, 5, 2], [5, 2, 5], [2, 5, 5]], float)
"""Points of a facet at which its sag is measured, times their sum."""


def sags_of(gmsh: Any) -> list[Sag]:
    """The sags of all surfaces that are not plane."""
    at = WITHIN / WITHIN.sum(1)[:, None]
    shape = np.hstack([at * (2 * at - 1), 4 * at * at[:, [1, 2, 0]]])
    tags, places, _ = gmsh.model.mesh.getNodes()
    x = np.zeros((int(tags.max()) + 1, 3))
    x[tags.astype(int)] = places.reshape(-1, 3)
    found = []
    for dim, tag in gmsh.model.getEntities(2):
        nodes = gmsh.model.mesh.getElementsByType(9, tag)[1].astype(int).reshape(-1, 6)
        if gmsh.model.getType(dim, tag) == 'Plane' or not len(nodes):
            continue
        points = np.einsum('sk,fki->fsi', shape, x[nodes])
        true = np.reshape(gmsh.model.getClosestPoint(2, tag, points.ravel())[0], points.shape)
        normal = np.cross(x[nodes[:, 1]] - x[nodes[:, 0]], x[nodes[:, 2]] - x[nodes[:, 0]])
        area = np.linalg.norm(normal, axis=1)
        normal /= area[:, None]
        ways = np.einsum('fsi,fi->fs', true - points, normal).mean(1)
        found.append(Sag(x[nodes[:, :3]].mean(1), area / 2, normal, ways))
    return found


def by_gmsh(geometry: Path, bodies: Optional[Bodies], h: Optional[NDArray], order: int, path: Path,
            size: Optional[float] = None) -> list[Sag]:
    """A mesh of a geometry (.geo, .step, .brep) with sizes h on the regions of `bodies`, or of one
    size; middle nodes lie on the true surface: what its facets sag all the same."""
    try:
        import gmsh
    except ImportError as problem:
        raise missing('gmsh') from problem
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber('General.Terminal', 0)
        gmsh.option.setNumber('Mesh.MshFileVersion', 2.2)
        gmsh.open(str(geometry))
        if bodies is not None and h is not None:
            set_background(gmsh, bodies, h)
        elif size is not None:
            gmsh.option.setNumber('Mesh.MeshSizeMin', size)
            gmsh.option.setNumber('Mesh.MeshSizeMax', size)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(3)
        if order == 2:
            gmsh.option.setNumber('Mesh.HighOrderOptimize', 1)
            gmsh.model.mesh.setOrder(2)
        gmsh.write(str(path))
        return sags_of(gmsh) if order == 2 else []
    except Exception as problem:  # gmsh raises nothing more special
        raise MeshError(f'gmsh makes no mesh of {geometry}: {problem}') from problem
    finally:
        gmsh.finalize()


def set_background(gmsh: Any, bodies: Bodies, h: NDArray) -> None:
    """One field of sizes for each region, on its own volumes: touching bodies have sizes of their own."""
    volumes = {gmsh.model.getPhysicalName(3, tag): gmsh.model.getEntitiesForPhysicalGroup(3, tag)
               for dim, tag in gmsh.model.getPhysicalGroups(3)}
    fields = []
    for number, name in enumerate(bodies.regions, 1):
        if name not in volumes:
            continue
        corners = bodies.cells[bodies.region == number, :4]
        data = np.concatenate([bodies.points[corners].transpose(0, 2, 1).reshape(-1, 12), h[corners]], 1)
        view = gmsh.view.add(name)
        gmsh.view.addListData(view, 'SS', len(data), data.ravel())
        field = gmsh.model.mesh.field
        post = field.add('PostView')
        field.setNumber(post, 'ViewTag', view)
        only = field.add('Restrict')
        field.setNumber(only, 'InField', post)
        field.setNumbers(only, 'VolumesList', list(volumes[name]))
        field.setNumber(only, 'IncludeBoundary', 1)
        fields.append(only)
    if not fields:
        raise MeshError('no physical volume of the geometry has the name of a region: '
                        + ', '.join(bodies.regions))
    least = gmsh.model.mesh.field.add('Min')
    gmsh.model.mesh.field.setNumbers(least, 'FieldsList', fields)
    gmsh.model.mesh.field.setAsBackgroundMesh(least)
    for option in ('MeshSizeExtendFromBoundary', 'MeshSizeFromPoints', 'MeshSizeFromCurvature'):
        gmsh.option.setNumber('Mesh.' + option, 0)
    gmsh.option.setNumber('Mesh.MeshSizeMin', float(0.5 * h.min()))
    gmsh.option.setNumber('Mesh.MeshSizeMax', float(2.0 * h.max()))
