"""What a picture shows: triangles with a colour each, strokes and arrows; two ways to draw it.

PyVista draws it where it is installed, matplotlib with our own pixels otherwise.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .cube import FIELDS as STRESSES
from .cube import camera, draw_axes, exterior_facets, facet_values
from .results import Results
from .surfaces import Surface, Surfaces

LIGHT = np.array([-0.35, -0.55, 0.76])
STATUS_NAMES = ('off', 'open', 'stick', 'slip')
STATUS_COLOURS = ('#e8e8e8', '#b8b8b8', style.BLUE, style.RED)
REGION_COLOURS = ('#8fbfdc', '#f2cf8a', '#8fd0b8', '#e6a583', '#c9b3d9', '#c8c8c8')


@dataclass
class Scene:
    """Triangles with colours, lines on them, and what the colours mean."""
    points: NDArray
    facets: NDArray
    values: NDArray
    label: str
    title: str = ''
    limits: Optional[tuple[float, float]] = None
    view: tuple[float, float] = (-60.0, 24.0)
    strokes: list[tuple[NDArray, NDArray]] = field(default_factory=list)
    """Lay: places, and vectors of length 1."""
    arrows: list[tuple[NDArray, NDArray]] = field(default_factory=list)
    """Shear tractions: places, and vectors."""
    size: float = 1.0
    """Length of a facet: the scale of strokes and arrows."""
    names: tuple[str, ...] = ()
    """What the values mean where they are kinds: the first is `first`, the next one more."""
    first: int = 0
    """The value of the first name."""
    colours: tuple[str, ...] = ()
    """The colours of the names."""


def with_unit(name: str, unit: str) -> str:
    """A name and its unit for a label."""
    return name if unit in ('', '1') else f'{name} [{unit}]'


def bodies(results: Results, frame: int = -1, name: str = 'mises', scale: float = 1.0,
           view: Optional[tuple[float, float]] = None) -> Scene:
    """The outer facets of all bodies, displaced `scale` times, coloured by a field."""
    index = results.index(frame)
    x = results.points
    faces, owner = exterior_facets(results.cells, x)
    if 'displacement' in results.vtk['PointData']:
        x = x + scale * results.point_field('displacement', index)
    values, label = body_values(results, index, name, faces, owner)
    title = f'time {results.times[index]:g}'
    if scale != 1.0:
        title += f', displacements {scale:g} times'
    return Scene(x, faces, values, label, title, view=view or (-60.0, 24.0),
                 size=facet_size(x, faces))


def mesh(results: Results, view: Optional[tuple[float, float]] = None) -> Scene:
    """The mesh before the run, a colour for each region."""
    x = results.points
    faces, owner = exterior_facets(results.cells, x)
    number, names = results.regions()
    used = [k for k in range(len(names)) if np.any(number[owner] == k + 1)]
    values = np.searchsorted(used, number[owner] - 1).astype(float)
    return Scene(x, faces, values, 'region', 'mesh', view=view or (-60.0, 24.0),
                 size=facet_size(x, faces), names=tuple(names[k] for k in used),
                 colours=tuple(REGION_COLOURS[k % len(REGION_COLOURS)] for k in range(len(used))))


def body_values(results: Results, index: int, name: str, faces: NDArray,
                owner: NDArray) -> tuple[NDArray, str]:
    """A field on the outer facets, and its name with its unit."""
    points, cells = results.vtk['PointData'], results.vtk['CellData']
    if name in STRESSES and name != 'displacement' and 'stress' in cells:
        values, label = facet_values(results, index, name, faces, owner)
        return values, with_unit(label, results.unit('stress'))
    if name in points and points[name].dtype.kind == 'f':
        values = results.point_field(name, index)
        return lengths(values)[faces].mean(axis=1), with_unit(name, results.unit(name))
    if name in points:
        return points[name][:][faces].mean(axis=1), name
    if name in cells and cells[name].dtype.kind == 'f':
        return lengths(results.cell_field(name, index))[owner], with_unit(name, results.unit(name))
    if name in cells:
        return cells[name][:][owner].astype(float), name
    known = sorted(set(points) | set(cells) | (set(STRESSES) if 'stress' in cells else set()))
    raise KeyError(f'{results.path} has no field {name}; it has: ' + ', '.join(known))


def lengths(values: NDArray) -> NDArray:
    """Vectors become their lengths, numbers stay."""
    return np.linalg.norm(values, axis=1) if values.ndim == 2 else values


def facet_size(x: NDArray, facets: NDArray) -> float:
    """Root of the mean area of facets."""
    if len(facets) == 0:
        return 1.0
    a, b, c = x[facets].transpose(1, 0, 2)
    return float(np.sqrt(np.linalg.norm(np.cross(b - a, c - a), axis=1).mean()))


def contact(surfaces: Surfaces, frame: int = -1, name: str = 'pressure',
            pairs: Optional[list[str]] = None, side: str = 'slave', scale: float = 1.0,
            view: Optional[tuple[float, float]] = None) -> Scene:
    """One side of some pairs (all without a list), coloured by a field, with lay and friction."""
    parts = [surfaces.surface(pair, side, frame) for pair in pairs or list(surfaces.pairs)]
    if not parts or sum(len(part.facets) for part in parts) == 0:
        raise KeyError(f'{surfaces.path} has no facets on the {side} side')
    points, facets, values, start = [], [], [], 0
    for part in parts:
        if name not in part.at_nodes:
            raise KeyError(f'{surfaces.path} has no field {name}; it has: '
                           + ', '.join(part.at_nodes))
        points.append(part.points + scale * part.at_nodes['displacement'])
        facets.append(part.facets + start)
        values.append(facet_colours(part, name))
        start += len(part.points)
    x, f = np.concatenate(points), np.concatenate(facets)
    colours = np.concatenate(values)
    if len(parts) > 1:
        kept = once(parts)
        f, colours = f[kept], colours[kept]
    index = frame + surfaces.steps if frame < 0 else frame
    scene = Scene(x, f, colours, with_unit(name, surfaces.unit(name)),
                  f'{", ".join(pairs or list(surfaces.pairs))}: {side} side, time '
                  f'{surfaces.times[index]:g}', size=facet_size(x, f))
    if name == 'status':
        scene.names, scene.first, scene.colours = STATUS_NAMES, -1, STATUS_COLOURS
    scene.view = view or towards_normal(x, f, side)
    largest = max(np.abs(np.nan_to_num(part.at_nodes['traction'])).max() for part in parts)
    for part, place in zip(parts, points):
        shear = np.nan_to_num(part.at_nodes['shear_traction'])
        scene.strokes.append((place, part.at_nodes['lay']))
        if np.abs(shear).max() > 1e-6 * largest:  # more than round-off
            scene.arrows.append((place, shear))
    return scene


def once(parts: list[Surface]) -> NDArray:
    """Places of the facets of all parts without those that lie twice: a surface in two pairs is seen
    with the larger force."""
    nodes = np.sort(np.concatenate([part.nodes[part.facets] for part in parts]), axis=1)
    force = np.concatenate([lengths(np.nan_to_num(part.at_facets['traction'])) for part in parts])
    order = np.lexsort((-force, *nodes.T))
    first = np.append(True, np.any(np.diff(nodes[order], axis=0) != 0, axis=1))
    return np.sort(order[first])


def facet_colours(part: Surface, name: str) -> NDArray:
    """The values of a field on the facets; a status is that of the facet."""
    if name in part.at_facets:
        return lengths(part.at_facets[name])
    return lengths(part.at_nodes[name])[part.facets].mean(axis=1)


def towards_normal(x: NDArray, facets: NDArray, side: str) -> tuple[float, float]:
    """Azimuth and elevation from which one looks onto the surface, the slave from behind: as if
    the master's eyes were closed and the slave were made of glass."""
    a, b, c = x[facets].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a).sum(axis=0) * (-1.0 if side == 'slave' else 1.0)
    if np.linalg.norm(normal) < 1e-9 * np.abs(np.cross(b - a, c - a)).sum():
        return -60.0, 24.0
    normal = normal / np.linalg.norm(normal)
    if abs(normal[2]) > 0.9:  # x to the right, y upwards
        return -90.0, float(np.copysign(90.0, normal[2]))
    azimuth = np.degrees(np.arctan2(normal[1], normal[0]))
    return float(azimuth), float(np.degrees(np.arcsin(np.clip(normal[2], -1, 1))))


def colour_limits(scene: Scene) -> tuple[float, float]:
    """The ends of the scale of colours."""
    if scene.names:
        return scene.first - 0.5, scene.first + len(scene.names) - 0.5
    if scene.limits:
        return scene.limits
    values = scene.values[np.isfinite(scene.values)]
    if len(values) == 0:
        return 0.0, 1.0
    low, high = np.percentile(values, [0.5, 99.5])
    spread = max(abs(low), abs(high), 1e-300)
    low = 0.0 if 0.0 < low < 0.02 * high else low
    return (low, high) if high - low > 1e-9 * spread else (low - 0.5 * spread, high + 0.5 * spread)


def colour_map(scene: Scene) -> Any:
    """The colours: viridis, or one for each kind."""
    import matplotlib as mpl
    if scene.names:
        return mpl.colors.ListedColormap(list(scene.colours))
    return mpl.colors.ListedColormap(mpl.colormaps['viridis'](np.linspace(0.12, 1.0, 256)))


def draw(scene: Scene, path: Optional[str] = None, renderer: str = 'auto',
         size: tuple[int, int] = (900, 680)) -> NDArray:
    """Draws a scene and returns the picture as (height, width, 3) bytes; writes it to `path`."""
    if renderer == 'auto':
        renderer = 'pyvista' if has_pyvista() else 'matplotlib'
    picture = (draw_with_pyvista if renderer == 'pyvista' else draw_with_matplotlib)(scene, size)
    if path:
        from PIL import Image
        Image.fromarray(picture).save(path)
    return picture


def has_pyvista() -> bool:
    """Whether PyVista can be used."""
    try:
        import pyvista  # noqa: F401
    except ImportError:
        return False
    return True


def scaled_lines(scene: Scene) -> tuple[list, list]:
    """Begin and end of the strokes of the lay, and of the arrows of friction."""
    strokes = [(at - 0.3 * scene.size * lay, at + 0.3 * scene.size * lay)
               for at, lay in scene.strokes if np.any(lay)]
    longest = max((np.linalg.norm(v, axis=1).max(initial=0.0) for _, v in scene.arrows),
                  default=0.0)
    arrows = []
    for at, v in scene.arrows:
        if longest <= 0.0:
            break
        seen = np.linalg.norm(v, axis=1) > 0.02 * longest
        arrows.append((at[seen], at[seen] + 0.9 * scene.size / longest * v[seen]))
    return strokes, arrows


def draw_with_matplotlib(scene: Scene, size: tuple[int, int]) -> NDArray:
    """Paints the facets pixel by pixel, lines and labels on top."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    style.pyplot()
    dpi = max(size[0] / 9, 72.0)  # small pictures keep letters that can be read
    figure = mpl.figure.Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
    canvas = FigureCanvasAgg(figure)
    below, above = round(0.62 * dpi), round(0.32 * dpi)
    box = [round(0.02 * size[0]), below, round(0.96 * size[0]), size[1] - below - above]
    axes = figure.add_axes(tuple(n / size[k % 2] for k, n in enumerate(box)))
    right, up, towards = camera(*scene.view)
    strokes, arrows = scaled_lines(scene)
    flat = np.stack([scene.points @ right, scene.points @ up], axis=-1)
    ends = [np.stack([p @ right, p @ up], -1) for line in strokes + arrows for p in line]
    low, unit = fit(np.concatenate([flat[np.unique(scene.facets)]] + ends), (box[2], box[3]))
    mapping = mpl.cm.ScalarMappable(mpl.colors.Normalize(*colour_limits(scene)), colour_map(scene))
    image, near = painted(scene, (flat - low) / unit, mapping, (box[2], box[3]))
    high = low + unit * np.array(box[2:])
    axes.imshow(image, extent=(low[0], high[0], low[1], high[1]), interpolation='nearest')
    strokes, arrows = ([visible(line, near, scene, low, unit) for line in lines]
                       for lines in (strokes, arrows))
    for begin, end in strokes:
        lines = np.stack([np.stack([p @ right, p @ up], -1) for p in (begin, end)], 1)
        axes.add_collection(LineCollection(list(lines), colors='white', linewidths=1.6, zorder=3))
        axes.add_collection(LineCollection(list(lines), colors=style.GREEN, linewidths=1.0,
                                           zorder=4))
    for begin, end in arrows:
        axes.quiver(begin @ right, begin @ up, (end - begin) @ right, (end - begin) @ up,
                    angles='xy', scale_units='xy', scale=1, color=style.INK, width=0.003, zorder=5)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.axis('off')
    axes.set_title(scene.title, fontsize=9)
    decorate(figure, axes, scene, mapping, (right, up, towards))
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def fit(points: NDArray, size: tuple[int, int]) -> tuple[NDArray, float]:
    """The lower left corner of a picture of so many pixels that shows all points, and the length of
    one pixel."""
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    unit = float(1.1 * (np.ptp(points, axis=0) / size).max()) or 1.0
    return centre - 0.5 * unit * np.array(size), unit


def visible(line: tuple[NDArray, NDArray], near: NDArray, scene: Scene, low: NDArray,
            unit: float) -> tuple[NDArray, NDArray]:
    """Of strokes or arrows those that do not begin far behind what is seen there."""
    right, up, towards = camera(*scene.view)
    begin, end = line
    at = ((np.stack([begin @ right, begin @ up], -1) - low) / unit).astype(int)
    at = np.clip(at, 0, np.array(near.shape)[::-1] - 1)
    seen = begin @ towards > near[at[:, 1], at[:, 0]] - 1.5 * scene.size
    return begin[seen], end[seen]


def painted(scene: Scene, flat: NDArray, mapping: Any,
            size: tuple[int, int]) -> tuple[NDArray, NDArray]:
    """The facets as pixels and how near these are; flat are the places of points in the picture."""
    from .painting import paint
    _, _, towards = camera(*scene.view)
    corners = scene.points[scene.facets]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    closed = not scene.strokes  # a surface of contact is seen from both sides
    seen = normal @ towards > 1e-9 if closed else np.ones(len(normal), dtype=bool)
    colour = mapping.to_rgba(np.ma.masked_invalid(scene.values[seen]))[:, :3]
    colour[~np.isfinite(scene.values[seen])] = 0.95
    if closed:
        shade = np.clip(normal[seen] @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
        colour = colour * (0.66 + 0.34 * shade[:, None])
    return paint(flat[scene.facets[seen]], (corners @ towards)[seen], colour,
                 np.clip(0.8 * colour, 0, 1), size)


def decorate(figure: Any, axes: Any, scene: Scene, mapping: Any, view: tuple) -> None:
    """The scale of colours, the axes, and what strokes and arrows mean."""
    from matplotlib.lines import Line2D
    from matplotlib.ticker import MaxNLocator, ScalarFormatter
    height = figure.get_figheight()
    bar_axes = figure.add_axes((0.25, 0.46 / height, 0.5, 0.12 / height))
    bar = figure.colorbar(mapping, cax=bar_axes, orientation='horizontal')
    bar.set_label(scene.label)
    bar.outline.set_visible(False)
    bar.locator = MaxNLocator(5 if figure.get_figwidth() > 7 else 3)
    bar.formatter = ScalarFormatter(useOffset=False)
    bar.formatter.set_powerlimits((-3, 5))
    if scene.names:
        bar.set_ticks(list(range(scene.first, scene.first + len(scene.names))), labels=scene.names)
        bar_axes.tick_params(length=0)
    corner = figure.add_axes((0.0, 0.0, 1.1 / figure.get_figwidth(), 1.1 / height))
    corner.set_xlim(-1.5, 1.5)
    corner.set_ylim(-1.5, 1.5)
    corner.axis('off')
    draw_axes(corner, view, np.zeros(2), 0.9)
    handles = []
    if any(np.any(lay) for _, lay in scene.strokes):
        handles.append(Line2D([], [], color=style.GREEN, label='lay'))
    if any(np.any(v) for _, v in scene.arrows):
        handles.append(Line2D([], [], color=style.INK, label='shear traction'))
    if handles:
        if figure.get_figwidth() > 5.5:
            figure.legend(handles=handles, loc='lower right', fontsize=8)
        else:  # no room beside the scale of colours
            axes.legend(handles=handles, loc='upper right', fontsize=7, borderaxespad=0)


def draw_with_pyvista(scene: Scene, size: tuple[int, int]) -> NDArray:
    """Draws off screen with VTK."""
    import pyvista
    cells = np.column_stack([np.full(len(scene.facets), 3), scene.facets]).ravel()
    mesh = pyvista.PolyData(scene.points, cells)
    mesh.cell_data['values'] = scene.values
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size))
    plotter.background_color = 'white'
    letter = 14 if size[0] > 600 else 11
    bar = {'title': scene.label + '\n', 'color': 'black', 'n_labels': 5, 'vertical': False,
           'position_x': 0.25, 'position_y': 0.02, 'width': 0.5, 'height': 0.12,
           'title_font_size': letter + 2, 'label_font_size': letter, 'fmt': '%.3g'}
    notes = {}
    if scene.names:
        notes = {'annotations': {float(scene.first + k): word
                                 for k, word in enumerate(scene.names)}}
        bar['n_labels'] = 0
    plotter.add_mesh(mesh, scalars='values', cmap=colour_map(scene), clim=colour_limits(scene),
                     show_edges=True, edge_color='#333333', edge_opacity=0.35, line_width=0.6,
                     nan_color='#f2f2f2',
                     scalar_bar_args=bar, lighting=not scene.strokes, ambient=0.0 if scene.strokes else 0.35,
                     **notes)
    strokes, arrows = scaled_lines(scene)
    _, _, towards = camera(*scene.view)
    for begin, end in strokes:
        plotter.add_mesh(lines_of(begin, end, 0.02 * scene.size * towards), color=style.GREEN,
                         line_width=3, lighting=False)
    for begin, end in arrows:
        glyphs = pyvista.PolyData(begin + 0.04 * scene.size * towards)
        glyphs['v'] = end - begin
        shape = pyvista.Arrow(tip_length=0.2, tip_radius=0.05, shaft_radius=0.015)
        plotter.add_mesh(glyphs.glyph(orient='v', scale='v', geom=shape), color=style.INK,
                         lighting=False)
    look(plotter, scene)
    plotter.add_text(scene.title, font_size=letter - 5, color='black', position='upper_left')
    plotter.add_axes(color='black')
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    return np.asarray(picture)[:, :, :3].copy()


def lines_of(begin: NDArray, end: NDArray, offset: NDArray) -> Any:
    """Lines between points."""
    import pyvista
    n = len(begin)
    cells = np.column_stack([np.full(n, 2), np.arange(n), np.arange(n, 2 * n)]).ravel()
    return pyvista.PolyData(np.concatenate([begin, end]) + offset, lines=cells)


def look(plotter: Any, scene: Scene) -> None:
    """Puts the camera, without perspective."""
    _, up, towards = camera(*scene.view)
    centre = 0.5 * (scene.points.min(axis=0) + scene.points.max(axis=0))
    reach = np.linalg.norm(np.ptp(scene.points, axis=0))
    plotter.camera.parallel_projection = True
    plotter.camera_position = [centre + 3 * reach * towards, centre, up]
    plotter.reset_camera()
    plotter.camera.parallel_scale *= 1.12
    shift = 0.2 * plotter.camera.parallel_scale * up
    plotter.camera.focal_point = np.asarray(plotter.camera.focal_point) - shift
    plotter.camera.position = np.asarray(plotter.camera.position) - shift
