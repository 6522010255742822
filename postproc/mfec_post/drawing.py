"""Draws scenes: PyVista the facets, off screen, matplotlib the words around them in print size."""
from __future__ import annotations

import importlib.util
import os
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .geometry import View, camera, edge_lines, facet_normals, refined
from .scene import Scene, colour_limits, seen_nodes, value_range

SIZE = (130.0, 98.0)
"""Width and height of a picture in print [mm]."""
DPI = 300
TITLE, BAR = 0.36, 0.66
"""Height of the lines above and of the scale of colours below [inch]."""
MANY = 420
"""About so many strokes of a lay or arrows of friction are drawn."""
EDGE, NET, TOOL = '#1a1a1a', '#8c8c8c', '#b9bec4'


def draw(scene: Scene, path: Optional[str] = None, size: tuple[float, float] = SIZE,
         dpi: float = DPI) -> NDArray:
    """Draws a scene and returns the picture as (height, width, 3) bytes; writes it to `path`, whose
    words are vectors if it is a .pdf or .svg."""
    return draw_row([scene], path, size, dpi)


def draw_row(scenes: list[Scene], path: Optional[str] = None, size: tuple[float, float] = SIZE,
             dpi: float = DPI) -> NDArray:
    """Draws scenes beside each other, each of the same size."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image
    style.use()
    width, height = (value / 25.4 for value in size)
    figure = Figure(figsize=(width * len(scenes), height), dpi=dpi)
    canvas = FigureCanvasAgg(figure)
    for k, scene in enumerate(scenes):
        draw_panel(figure, scene, (k * width, 0.0, width, height), dpi)
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
    if path and path.lower().endswith(('.pdf', '.svg', '.eps')):
        figure.savefig(path, dpi=dpi, bbox_inches=None)
    elif path:
        Image.fromarray(picture).save(path, dpi=(dpi, dpi))
    return picture


def draw_panel(figure: Any, scene: Scene, box: tuple[float, float, float, float],
               dpi: float) -> None:
    """One scene in a box of a figure [inch]."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    left, _, width, height = box
    pixels = (max(int((width - 0.08) * dpi), 16), max(int((height - BAR - TITLE) * dpi), 16))
    figure.figimage(rendered(scene, pixels, dpi), round((left + 0.04) * dpi), round(BAR * dpi),
                    origin='upper')
    words(figure, scene, box)
    scale_of_colours(figure, scene, ScalarMappable(Normalize(*colour_limits(scene)),
                                                   colour_map(scene)), box)


def fraction(figure: Any, box: tuple[float, float, float, float]) -> tuple[float, ...]:
    """A box in inches as parts of the figure."""
    width, height = figure.get_size_inches()
    return box[0] / width, box[1] / height, box[2] / width, box[3] / height


def colour_map(scene: Scene) -> Any:
    """The colours: viridis, or one for each kind."""
    import matplotlib as mpl
    if scene.names:
        return mpl.colors.ListedColormap(list(scene.colours))
    return mpl.colormaps['viridis']


def words(figure: Any, scene: Scene, box: tuple[float, float, float, float]) -> None:
    """The title, a note, what strokes and arrows mean, and the axes."""
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import Normal, Stroke
    left, _, width, height = box
    x, top, _, _ = fraction(figure, (left + 0.06, height - 0.06, 0, 0))
    figure.text(x, top, scene.title, fontsize=9, va='top')
    if scene.note:
        _, lower, _, _ = fraction(figure, (0, height - 0.22, 0, 0))
        figure.text(x, lower, scene.note, fontsize=7.5, va='top', color=style.RED)
    handles = []
    if any(np.any(lay) for _, lay in scene.strokes):
        handles.append(Line2D([], [], color='white', lw=0.8, label='lay', path_effects=[
            Stroke(linewidth=1.6, foreground=style.INK), Normal()]))
    if scene.arrows:
        handles.append(Line2D([], [], color=style.RED, lw=1.0, marker='>', markersize=4,
                              markevery=[1], label='shear traction'))
    if handles:
        right, low, _, _ = fraction(figure, (left + width - 0.05, 0.06, 0, 0))
        figure.legend(handles=handles, loc='lower right', bbox_to_anchor=(right, low), fontsize=6.5,
                      borderaxespad=0, borderpad=0, handlelength=1.2, labelspacing=0.3,
                      handletextpad=0.4)
    corner = figure.add_axes(fraction(figure, (left + 0.02, 0.02, 0.54, 0.54)))
    corner.set_xlim(-1.5, 1.5)
    corner.set_ylim(-1.5, 1.5)
    corner.axis('off')
    draw_axes(corner, camera(*scene.view), np.zeros(2), 0.9)


def draw_axes(axes: Any, view: View, corner: NDArray, length: float) -> None:
    """A small cross of axes; the one that points at the reader has no arrow."""
    for k, name in enumerate('xyz'):
        tip = length * np.array([view[0][k], view[1][k]])
        if np.linalg.norm(tip) < 0.15 * length:
            continue
        axes.annotate('', corner + tip, corner, annotation_clip=False,
                      arrowprops={'arrowstyle': '-|>', 'color': style.INK, 'lw': 0.8,
                                  'shrinkA': 0, 'shrinkB': 0, 'mutation_scale': 6})
        axes.text(*(corner + 1.35 * tip), name, ha='center', va='center', fontsize=7.5)


def scale_of_colours(figure: Any, scene: Scene, mapping: Any,
                     box: tuple[float, float, float, float]) -> None:
    """The scale of colours, or the names of kinds."""
    from matplotlib.patches import Patch
    from matplotlib.ticker import MaxNLocator, ScalarFormatter
    left, _, width, _ = box
    if scene.names:
        axes = figure.add_axes(fraction(figure, (left + 0.16 * width, 0.04, 0.6 * width, 0.5)))
        axes.axis('off')
        handles = [Patch(facecolor=c, edgecolor=style.INK, lw=0.4, label=n)
                   for n, c in zip(scene.names, scene.colours)]
        axes.legend(handles=handles, loc='center', ncol=min(4, len(handles)), fontsize=7.5,
                    title=scene.label, title_fontsize=7.5, handlelength=1.0, columnspacing=1.2)
        return
    low, high = value_range(scene)
    ends = mapping.get_clim()
    slack = 1e-6 * (ends[1] - ends[0])
    beyond = {(True, True): 'both', (True, False): 'min', (False, True): 'max',
              (False, False): 'neither'}[low < ends[0] - slack, high > ends[1] + slack]
    axes = figure.add_axes(fraction(figure, (left + 0.24 * width, 0.52, 0.46 * width, 0.09)))
    bar = figure.colorbar(mapping, cax=axes, orientation='horizontal', extend=beyond)
    bar.outline.set_linewidth(0.4)
    bar.locator = MaxNLocator(5 if width > 4 else 3)
    bar.formatter = ScalarFormatter(useOffset=False, useMathText=True)
    bar.formatter.set_powerlimits((-3, 5))
    axes.tick_params(labelsize=7.5, length=2, pad=2)
    axes.xaxis.get_offset_text().set_fontsize(7.5)
    bar.set_label(f'{scene.label}\n{low:.4g} to {high:.4g}', fontsize=7.5, labelpad=1)


def has_pyvista() -> bool:
    """Whether PyVista can be used."""
    return importlib.util.find_spec('pyvista') is not None


def plotter_of(size: tuple[int, int]) -> Any:
    """A plotter without a window; KeyError where PyVista is missing."""
    try:
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger
    except ImportError as missing:
        raise KeyError("pictures want PyVista: pip install 'mfec[pictures]'") from missing
    if not os.environ.get('DISPLAY'):  # VTK looks for a window first and complains
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size), lighting='none')
    plotter.set_background('white')
    plotter.enable_anti_aliasing('ssaa' if size[0] * size[1] < 3e6 else 'msaa')
    return plotter


def rendered(scene: Scene, size: tuple[int, int], dpi: float) -> NDArray:
    """The facets, their edges, tools, strokes and arrows as pixels."""
    plotter = plotter_of(size)
    import pyvista
    view = camera(*scene.view)
    reach = float(np.linalg.norm(np.ptp(scene.points[seen_nodes(scene)], axis=0))) or 1.0
    plotter.add_light(pyvista.Light(position=tuple(view[2] + 0.5 * view[1] - 0.4 * view[0]),
                                    light_type='scene light', intensity=1.0))
    add_facets(plotter, scene, view[2], reach, dpi)
    for points, facets in scene.tools:
        tool = surface(drawn_back(points, facets, 4e-3 * reach), facets)
        tool = tool.clip_box(fit_box(scene), invert=False).extract_surface() \
            if is_far(points, scene) else tool
        plotter.add_mesh(tool, color=TOOL, opacity=0.45, smooth_shading=True, ambient=0.5,
                         diffuse=0.5, culling=None if is_far(points, scene) else 'back')
    strokes, arrows = scaled_lines(scene, view[2])
    lift = 2e-3 * reach * view[2]
    for begin, end in strokes:
        for times, colour, wide in ((1, style.INK, 1.5), (2, 'white', 0.8)):  # seen on any colour
            plotter.add_mesh(lines(np.stack([begin, end], 1) + times * lift), color=colour,
                             line_width=wide * dpi / 72, lighting=False)
    for begin, end in arrows:
        glyphs = pyvista.PolyData(begin + 3 * lift)
        glyphs['v'] = end - begin
        shape = pyvista.Arrow(tip_length=0.35, tip_radius=0.12, shaft_radius=0.035)
        plotter.add_mesh(glyphs.glyph(orient='v', scale='v', geom=shape), color=style.RED,
                         lighting=False)
    look(plotter, scene, view, size)
    picture = np.asarray(plotter.screenshot(return_img=True))[:, :, :3].copy()
    plotter.close()
    return picture


def add_facets(plotter: Any, scene: Scene, towards: NDArray, reach: float, dpi: float) -> None:
    """The facets in their colours, and the edges of the mesh."""
    places, triangles, parent = refined(scene.points, scene.facets, scene.mids)
    shown = surface(places, triangles)
    if scene.at_facets:
        shown.cell_data['values'] = scene.values[parent]
    else:
        shown.point_data['values'] = refined(scene.values, scene.facets, scene.mids)[0]
    shaded = {'lighting': False} if scene.is_surface else {'ambient': 0.55, 'diffuse': 0.5}
    plotter.add_mesh(shown, scalars='values', cmap=colour_map(scene), clim=colour_limits(scene),
                     nan_color='#f2f2f2', show_scalar_bar=False, interpolate_before_map=True,
                     culling='back' if scene.is_closed else None, **shaded)
    facets, mids = scene.facets, scene.mids
    if scene.is_closed:
        front = facet_normals(scene.points, facets) @ towards > 0
        facets, mids = facets[front], mids[front]
    net = edge_lines(scene.points, facets, mids) + 5e-4 * reach * towards
    fine = min(1.0, 90 / max(len(net), 1) ** 0.5)  # dense meshes get fainter lines
    plotter.add_mesh(lines(net), color=NET, line_width=0.3 * dpi / 72, opacity=0.2 + 0.5 * fine,
                     lighting=False)
    rims = shown.clean().extract_feature_edges(40.0, manifold_edges=False)
    if rims.n_points and not scene.is_closed:
        rims.points = rims.points + 8e-4 * reach * towards
        plotter.add_mesh(rims, color=EDGE, line_width=0.7 * dpi / 72, lighting=False)


def surface(points: NDArray, triangles: NDArray) -> Any:
    """Triangles as VTK has them."""
    import pyvista
    return pyvista.PolyData.from_regular_faces(np.ascontiguousarray(points, dtype=float), triangles)


def lines(places: NDArray) -> Any:
    """Lines (lines, points of a line, 3) as VTK has them."""
    import pyvista
    count, length = places.shape[:2]
    ids = np.arange(count * length).reshape(count, length)
    cells = np.column_stack([np.full(count, length), ids]).ravel()
    return pyvista.PolyData(places.reshape(-1, 3), lines=cells)


def drawn_back(points: NDArray, facets: NDArray, by: float) -> NDArray:
    """A tool behind where it is, so that bodies that touch it are seen before it."""
    normals = np.zeros_like(points)
    np.add.at(normals, facets.ravel(), np.repeat(facet_normals(points, facets), 3, axis=0))
    return points - by * normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def is_far(points: NDArray, scene: Scene) -> bool:
    """Whether a tool goes far beyond the bodies."""
    bodies = np.ptp(scene.points[seen_nodes(scene)], axis=0).max()
    return bool(np.ptp(points, axis=0).max() > 2.0 * bodies)


def fit_box(scene: Scene) -> list[float]:
    """A box around the bodies, wider than they are."""
    points = scene.points[seen_nodes(scene)]
    more = 0.35 * np.ptp(points, axis=0).max()
    low, high = points.min(axis=0) - more, points.max(axis=0) + more
    return list(np.stack([low, high], axis=1).ravel())


def look(plotter: Any, scene: Scene, view: View, size: tuple[int, int]) -> None:
    """Puts the camera, without perspective, so that all facets and near tools are in the picture."""
    right, up, towards = view
    points = np.concatenate([scene.points[seen_nodes(scene)]] + [
        np.clip(p, *np.array(fit_box(scene)).reshape(3, 2).T) for p, _ in scene.tools])
    flat = np.stack([points @ right, points @ up], axis=1)
    low, high = flat.min(axis=0), flat.max(axis=0)
    deep = points @ towards
    centre = (0.5 * (low + high)) @ np.array([right, up]) + 0.5 * (deep.min() + deep.max()) * towards
    reach = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    half = 0.53 * max(high[1] - low[1], (high[0] - low[0]) * size[1] / size[0]) or 1.0
    plotter.camera_position = [centre + 3 * reach * towards, centre, up]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = half
    plotter.camera.clipping_range = (0.5 * reach, 6 * reach)


def scaled_lines(scene: Scene, towards: NDArray) -> tuple[list, list]:
    """Begin and end of strokes of the lay, and of arrows of friction: those in front, spread evenly."""
    area = 0.5 * np.linalg.norm(facet_normals(scene.points, scene.facets), axis=1).sum()
    spacing = max(float(np.sqrt(area / MANY)), 1e-300)
    strokes = []
    for at, lay in scene.strokes:
        at, lay = spread(scene, at, lay, spacing, towards)
        if np.any(lay):
            strokes.append((at - 0.32 * spacing * lay, at + 0.32 * spacing * lay))
    longest = max((np.linalg.norm(v, axis=1).max(initial=0.0) for _, v in scene.arrows),
                  default=0.0)
    arrows = []
    for at, v in scene.arrows:
        at, v = spread(scene, at, v, spacing, towards)
        seen = np.linalg.norm(v, axis=1) > 0.03 * longest
        if np.any(seen):
            arrows.append((at[seen], at[seen] + 1.5 * spacing / longest * v[seen]))
    return strokes, arrows


def spread(scene: Scene, at: NDArray, vectors: NDArray, spacing: float,
           towards: NDArray) -> tuple[NDArray, NDArray]:
    """Of vectors at nodes one in each cube of a grid, and none on the side that is not drawn."""
    kept: NDArray = np.flatnonzero(np.any(vectors != 0, axis=1))
    if scene.is_closed and len(kept):
        normals = np.zeros((len(scene.points), 3))
        np.add.at(normals, scene.facets.ravel(),
                  np.repeat(facet_normals(scene.points, scene.facets), 3, axis=0))
        hidden = {tuple(p) for p in scene.points[normals @ towards <= 0]}
        kept = np.array([k for k in kept if tuple(at[k]) not in hidden], dtype=int)
    if len(kept) == 0:
        return at[kept], vectors[kept]
    cubes = np.floor((at[kept] - at.min(axis=0)) / spacing).astype(int)
    _, first = np.unique(cubes, axis=0, return_index=True)
    return at[kept[first]], vectors[kept[first]]
