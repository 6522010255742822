#!/usr/bin/env python3
"""The figures of the manuals and the gallery, drawn from runs of the program.

    build/venv/bin/python doc/figures.py [NAME...]        figures into doc/pictures (all, or those named)
    build/venv/bin/python doc/figures.py --gallery        doc/gallery.md and doc/gallery/*.png
    build/venv/bin/python doc/figures.py --stale          names what is older than what it shows

Beside the pictures lies made_from.txt: for each picture a digest of the decks it was computed from
and of the procedure that drew it. A test wants these digests to be those of today's files.
"""
import argparse
import glob
import hashlib
import inspect
import os
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(HERE)
sys.path.insert(0, os.path.join(TOP, 'postproc'))
sys.path.insert(0, HERE)
from mfec_post import Results, Surfaces, demo, drawing, geometry, read_table, rows_of, scene, style  # noqa: E402
from mfec_post import lay as lay_script  # noqa: E402

import scenes  # noqa: E402

PICTURES = os.path.join(HERE, 'pictures')
GALLERY = os.path.join(HERE, 'gallery')
PANEL = (84.0, 70.0)
"""Width and height of a picture in print [mm]."""


def deck_text(deck):
    """A deck of the tree."""
    with open(os.path.join(TOP, deck), encoding='ascii') as stream:
        return stream.read()


def meshes(deck):
    """The mesh files of a deck."""
    folder = os.path.dirname(os.path.join(TOP, deck))
    return [os.path.join(folder, name)
            for name in re.findall(r'(?m)^MESH +(\S+)', deck_text(deck))]


def run(folder, deck, options=(), changes=(), check=False):
    """Runs a deck with parts replaced; the base path of its files."""
    text = deck_text(deck)
    for old, new in changes:
        if old not in text:
            raise SystemExit(f'{deck} no longer holds: {old}')
        text = text.replace(old, new)
    work = tempfile.mkdtemp(dir=folder)
    base = os.path.join(work, 'x')
    for path in meshes(deck):
        os.symlink(path, os.path.join(work, os.path.basename(path)))
    with open(base + '.inp', 'w', encoding='ascii') as stream:
        stream.write(text)
    subprocess.run([os.path.join(TOP, 'mfec'), 'x.inp', '--quiet', *options]
                   + ['--check'] * check, cwd=work, check=True,
                   env=dict(os.environ, OPENBLAS_NUM_THREADS='1'))
    return base


# ---- the figures; each names its decks ------------------------------------------------------


def cone(folder, plt):
    """The tip of the cone is dragged behind the slave point when it slips."""
    base = run(folder, 'inputs/two_facet_edge.inp', ['--set', 'mu=0.6'])
    with Results(base + '.vtkhdf') as results:
        pair = next(iter(results.pairs))
        index = {n: i for i, n in enumerate(results.node_numbers)}
        slave, tip, status, force = [], [], [], []
        for frame in range(results.steps):
            at = results.contact(pair, frame)
            x = results.points + results.point_field('displacement', frame)
            if at['host'][0] == 0:
                continue
            corners = x[[index[n] for n in at['facets'][at['host'][0] - 1]]]
            xi, eta = at['tip'][0]
            tip.append(np.array([xi, eta, 1 - xi - eta]) @ corners)
            slave.append(x[index[at['node'][0][0]]])
            status.append(at['status'][0])
            force.append(at['traction'][0])
    slave, tip, status, force = map(np.array, (slave, tip, status, force))
    figure = plt.figure(figsize=(6.7, 4.9))
    elliptic_cone(figure.add_axes((0.0, 0.34, 1.0, 0.74), projection='3d'))
    axes = figure.add_axes((0.09, 0.13, 0.88, 0.27))
    depth = np.abs(slave - tip).max()
    size = 0.14 * np.ptp(slave[:, 0]) / depth
    for k in range(0, len(tip), 2):
        gap = slave[k] - tip[k]
        end = tip[k] + size * gap
        colour = style.RED if status[k] == 2 else style.BLUE
        near = min(max(k, 1), len(tip) - 2)
        along = tip[near + 1] - tip[near - 1]
        along = along / np.linalg.norm(along) if np.any(along) else np.array([1.0, 0.0, 0.0])
        normal = np.array([along[2], 0.0, -along[0]])  # into the master
        deep = 1.15 * size * abs(gap @ normal)
        rim = [tip[k] + deep * (normal + sign * 0.6 * along) for sign in (-1, 1)]
        axes.fill([tip[k][0], rim[0][0], rim[1][0]], [tip[k][2], rim[0][2], rim[1][2]],
                  color=style.ORANGE, alpha=0.22, lw=0)
        axes.annotate('', (end[0], end[2]), (tip[k][0], tip[k][2]), annotation_clip=False,
                      arrowprops={'arrowstyle': '-|>', 'color': colour, 'lw': 1.1, 'shrinkA': 0,
                                  'shrinkB': 0, 'mutation_scale': 8})
    axes.plot(tip[:, 0], tip[:, 2], '-', color=style.GREY, lw=1, label='surface of the master')
    axes.plot(tip[::2, 0], tip[::2, 2], 'o', color=style.INK, ms=3, label='apex')
    axes.fill([], [], color=style.ORANGE, alpha=0.3, label='section of the cone')
    axes.plot([], [], color=style.BLUE, label='gap vector, stick')
    axes.plot([], [], color=style.RED, label='gap vector, slip')
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('$x_1$')
    axes.set_ylabel('$x_3$')
    axes.legend(loc='upper center', bbox_to_anchor=(0.48, -0.28), ncol=5, fontsize=7.5,
                handlelength=1.2, columnspacing=1.0)
    figure.text(0.02, 0.97, '(a)')
    figure.text(0.02, 0.41, f'(b)  a node slides over a kinked edge; gaps {size:.0f} times', fontsize=9)
    return figure


def elliptic_cone(axes):
    """The cone of an elliptical law under a facet: a point that sticks, and one that slips."""
    mu1, mu2, deep = 0.75, 0.42, 1.0
    turn, down = np.meshgrid(np.linspace(0, 2 * np.pi, 73), np.linspace(0, deep, 9))
    facet = np.array([[-1.3, -0.95, 0], [1.5, -0.75, 0], [0.1, 1.35, 0], [-1.3, -0.95, 0]])
    axes.plot_trisurf(facet[:3, 0], facet[:3, 1], facet[:3, 2], color=style.GREY, alpha=0.25)
    axes.plot(*facet.T, color=style.GREY, lw=1)
    axes.plot_surface(mu1 * down * np.cos(turn), mu2 * down * np.sin(turn), -down, color=style.ORANGE,
                      alpha=0.35, linewidth=0)
    rim = np.linspace(0, 2 * np.pi, 73)
    axes.plot(mu1 * deep * np.cos(rim), mu2 * deep * np.sin(rim), -deep, color=style.ORANGE, lw=1.2)
    axes.plot([-1.1, 1.1], [0, 0], [0, 0], color=style.GREEN, lw=1, ls='--')
    axes.text(1.15, 0, 0.02, 'lay, $\\mu_1$', color=style.GREEN, fontsize=9)
    stick, at = np.array([-0.25, 0.0, -0.85]), np.radians(-40)
    slip = np.array([mu1 * 0.8 * np.cos(at), mu2 * 0.8 * np.sin(at), -0.8])
    for point, colour, word in ((stick, style.BLUE, 'inside: stick'), (slip, style.RED,
                                                                       'on the cone: slip')):
        axes.quiver(0, 0, 0, *point, color=colour, arrow_length_ratio=0.12, lw=1.5)
        axes.text(0.85 * np.sign(point[0]), 0, -0.85, word, color=colour, fontsize=9,
                  ha='right' if point[0] < 0 else 'left')
    axes.plot([0], [0], [0], 'o', color=style.INK, ms=4)
    axes.text(-0.05, 0, 0.1, 'apex', fontsize=9, ha='right')
    axes.set_box_aspect((3.1, 2.3, 1.2), zoom=1.25)
    axes.view_init(elev=12, azim=-68)
    axes.set_axis_off()


cone.decks = ['inputs/two_facet_edge.inp']
cone.sources = [inspect.getsource(elliptic_cone)]


def ellipse(folder, plt):
    """Friction forces over the normal force, in the axes of the lay, for the three slip rules."""
    deck, marks = 'inputs/sliding_cube_rigid.inp', {'COLLinear': 'o', 'TENSor': 's',
                                                    'ASSOciated': '^'}
    figure, axes = plt.subplots(figsize=(5.4, 4.6))
    turn = np.linspace(0, 2 * np.pi, 200)
    axes.plot(0.2 * np.cos(turn), 0.08 * np.sin(turn), color=style.GREY, lw=1,
              label='cone: $(t_1/\\mu_1)^2 + (t_2/\\mu_2)^2 = p^2$')
    for colour, (rule, mark) in zip((style.BLUE, style.GREEN, style.RED), marks.items()):
        points, ways = [], []
        for phi in (15, 30, 45, 60, 75):
            base = run(folder, deck, ['--set', f'phi={phi}', '--set', 'n=1', '--set', 'nx=4',
                                      '--set', 'ny=3', '--set', 'nz=1', '--set', 'npress=1',
                                      '--set', 'nslide=3', '--set', 'mu1=0.2', '--set',
                                      'mu2=0.08'],
                       [('    DIREction', f'    SLIP {rule}\n    DIREction')])
            row = rows_of(read_table(base + '.rea'), 'top')[-1]
            c, s = np.cos(np.radians(phi)), np.sin(np.radians(phi))
            pull = np.array([row['R1'], row['R2']]) / abs(row['R3'])
            points.append([c * pull[0] + s * pull[1], s * pull[0] - c * pull[1]])
            ways.append([c, s])
        points, ways = np.array(points), np.array(ways)
        axes.plot(points[:, 0], points[:, 1], mark, color=colour, ms=6, label=f'SLIP {rule}')
        axes.quiver(points[:, 0], points[:, 1], 0.045 * ways[:, 0], 0.045 * ways[:, 1],
                    angles='xy', scale_units='xy', scale=1, color=colour, width=0.004)
    axes.set_aspect('equal')
    axes.set_xlim(0, 0.27)
    axes.set_ylim(0, 0.15)
    axes.set_xlabel('force along the lay over normal force')
    axes.set_ylabel('across it')
    axes.set_title('the force that moves a cube (marks) and the way it slips (arrows)', fontsize=9)
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.16), ncol=2)
    return figure


ellipse.decks = ['inputs/sliding_cube_rigid.inp']


def forms(folder, plt):
    """Pressure between two meshes that do not match: nodes, quadrature points, segments."""
    import matplotlib as mpl
    text = deck_text('inputs/manual/two_meshes.inp')
    line = next(s for s in text.split('\n') if s.strip().startswith('GTOS'))
    sides = ' '.join(line.split()[1:3])
    figure, all_axes = plt.subplots(1, 3, figsize=(8.6, 3.2))
    norm = mpl.colors.Normalize(0.9 * 6.6858, 1.1 * 6.6858)
    for axes, form in zip(all_axes, (f'NTOS {sides}', f'GTOS {sides}', f'GTOS {sides} SEGMent')):
        base = run(folder, 'inputs/manual/two_meshes.inp', (), [(line, '    ' + form)])
        with Surfaces(base + '.contact.vtkhdf') as surfaces:
            pair = next(iter(surfaces.pairs))
            slave, master = surfaces.surface(pair), surfaces.surface(pair, 'master')
        p = slave.at_nodes['pressure']
        drawn = axes.tripcolor(slave.points[:, 0], slave.points[:, 1], slave.facets, p, norm=norm,
                               shading='gouraud', cmap='viridis')
        axes.triplot(slave.points[:, 0], slave.points[:, 1], slave.facets, color='white', lw=0.8)
        axes.triplot(master.points[:, 0], master.points[:, 1], master.facets, color=style.INK,
                     lw=0.5, ls=':')
        axes.set_aspect('equal')
        axes.axis('off')
        word = form.split()[0] + (' SEGMent' if 'SEGM' in form else '')
        axes.set_title(f'{word}\n{p.min():.3f} to {p.max():.3f}', fontsize=9)
    bar = figure.colorbar(drawn, ax=all_axes, orientation='horizontal', fraction=0.06, pad=0.04, extend='both')
    bar.set_label('pressure at the nodes; exact: 6.6858 everywhere (white: slave, dotted: master)')
    return figure


forms.decks = ['inputs/manual/two_meshes.inp']


def hosts(folder, plt):
    """The facet that holds the tip, along the way of a node over an edge."""
    base = run(folder, 'inputs/two_facet_edge.inp', ['--set', 'slope=0.2'])
    figure, axes = plt.subplots(figsize=(6.0, 3.4))
    with Results(base + '.vtkhdf') as results:
        pair = next(iter(results.pairs))
        index = {n: i for i, n in enumerate(results.node_numbers)}
        place, host, force = [], [], []
        for frame in range(results.steps):
            at = results.contact(pair, frame)
            x = results.points + results.point_field('displacement', frame)
            place.append(x[index[at['node'][0][0]]])
            host.append(at['host'][0])
            a, b, c = x[[index[n] for n in at['facets'][host[-1] - 1]]]
            normal = np.cross(b - a, c - a)
            normal /= np.linalg.norm(normal)
            force.append(at['traction'][0] - (at['traction'][0] @ normal) * normal)
        facets = np.array([[index[n] for n in f] for f in at['facets']])
    place, host, force = map(np.array, (place, host, force))
    colours = (style.BLUE, style.ORANGE, style.GREEN, style.RED)
    for k, facet in enumerate(facets):
        corners = x[np.append(facet, facet[0])]
        axes.fill(corners[:, 0], corners[:, 1], color=colours[k % 4], alpha=0.25)
        axes.plot(corners[:, 0], corners[:, 1], color=style.GREY, lw=0.8)
        mine = host == k + 1
        axes.plot(place[mine, 0], place[mine, 1], 'o', color=colours[k % 4], ms=4,
                  label=f'on master facet {k + 1}')
    size = 0.12 / np.linalg.norm(force, axis=1).max()
    axes.quiver(place[::3, 0], place[::3, 1] + 0.08, size * force[::3, 0], size * force[::3, 1],
                angles='xy', scale_units='xy', scale=1, width=0.003, color=style.INK)
    axes.set_aspect('equal')
    axes.set_xlabel('x')
    axes.set_ylabel('y')
    axes.set_title('seen from above: the node keeps its friction (arrows) at the edge', fontsize=9)
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.18), ncol=2)
    return figure


hosts.decks = ['inputs/two_facet_edge.inp']


def lays(folder, plt):
    """Five lays on one surface, as --check shows them."""
    deck = 'inputs/manual/turned_disc.inp'
    old = 'DIREction MATErial CIRCumferential 0 0 0  0 0 1'
    figure, all_axes = plt.subplots(1, 5, figsize=(10, 2.4))
    for axes, words in zip(all_axes, (
            'DIREction 1 0.3 0', 'DIREction ANGLe 60 1 0 0', 'DIREction CIRCumferential 0 0 0 0 0 1',
            'DIREction RADIal 0 0 0 0 0 1', 'DIREction ANGLe 45 RADIal 0 0 0 0 0 1')):
        base = run(folder, deck, (), [(old, words)], check=True)
        with Surfaces(base + '.check.contact.vtkhdf') as surfaces:
            master = surfaces.surface(next(iter(surfaces.pairs)), 'master')
        x, lay = master.points, master.at_nodes['lay']
        half = 0.35 * geometry.facet_size(x, master.facets)
        axes.triplot(x[:, 0], x[:, 1], master.facets, color=style.GRID, lw=0.5)
        begin, end = x - half * lay, x + half * lay
        axes.plot([begin[:, 0], end[:, 0]], [begin[:, 1], end[:, 1]], color=style.GREEN, lw=1.2)
        axes.set_aspect('equal')
        axes.set(xlim=(x[:, 0].min() - half, x[:, 0].max() + half),
                 ylim=(x[:, 1].min() - half, x[:, 1].max() + half))
        axes.axis('off')
        axes.set_title(words.replace('DIREction ', '').replace(' 0 0 0 0 0 1', ' ...'), fontsize=8)
    return figure


lays.decks = ['inputs/manual/turned_disc.inp']


def smooth(folder, plt):
    """The force on a pin that is led around a drum of flat facets, with SMOOth and without."""
    deck = 'inputs/manual/turning_pin.inp'
    figure, axes = plt.subplots(figsize=(5.6, 3.0))
    for label, changes, colour in (('flat facets', [('    SMOOth\n', '')], style.GREY),
                                   ('SMOOth', [], style.BLUE)):
        rows = read_table(run(folder, deck, (), changes) + '.con')
        axes.plot(rows['time'], rows['Fn'], '.-', color=colour, label=label)
    axes.set_xlabel('time')
    axes.set_ylabel('normal force on the pin')
    axes.set_ylim(bottom=0)
    axes.legend()
    return figure


smooth.decks = ['inputs/manual/turning_pin.inp']


def module_text(name):
    """The text of a module of mfec_post."""
    with open(os.path.join(TOP, 'postproc', 'mfec_post', name + '.py'), encoding='utf-8') as stream:
        return stream.read()


def fig6(folder, _):
    """The figure of the README: friction over normal force of five runs, as `make demo` draws it."""
    out = os.path.join(folder, 'demo')
    if demo.main(['--program', os.path.join(TOP, 'mfec'), '--out', out]) != 0:
        raise SystemExit('the demo has failed')
    return os.path.join(out, 'reactions.png')


fig6.decks = ['inputs/sliding_cube.inp']
fig6.sources = [module_text('demo'), module_text('reactions')]


def lay(folder, _):
    """The lay of a turned disc and the friction on a block at three end times."""
    base = run(folder, 'inputs/manual/turned_disc.inp')
    path = base + '.png'
    if lay_script.main([base + '.vtkhdf', '--out', path]) != 0:
        raise SystemExit('plot_lay has failed')
    return path


lay.decks = ['inputs/manual/turned_disc.inp']
lay.sources = [module_text('lay')]

FIGURES = {f.__name__: f for f in (cone, ellipse, fig6, forms, hosts, lay, lays, smooth)}

# ---- the gallery ----------------------------------------------------------------------------

def deck_of(name):
    """The path of a deck of inputs/."""
    return f'inputs/{name}.inp'


def panel(base, what, frame, view):
    """One scene of a run: `mesh`, `bodies:FIELD`, `slave:FIELD` or `master:FIELD`, with `:PAIR` or all."""
    kind, field, pair = (what.split(':') + ['', ''])[:3]
    with open(base + '.inp', encoding='ascii') as stream:
        units = scene.Units('mm', 'N') if '(N, mm' in stream.read() else None
    if kind in ('mesh', 'bodies'):
        with Results(base + '.vtkhdf') as results:
            return scene.mesh(results, view) if kind == 'mesh' else scene.bodies(results, frame, field,
                                                                                 1.0, view, units)
    with Surfaces(base + '.contact.vtkhdf') as surfaces:
        return scene.contact(surfaces, frame, field, [pair] if pair else None, kind, 1.0, view, units)


def curve_picture(x, y, x_label, y_label, size):
    """A curve in a picture of so many pixels at 300 dpi."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    style.use()
    figure = Figure(figsize=(size[0] / 300, size[1] / 300), dpi=300)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.2, 0.2, 0.75, 0.72))
    axes.plot(x, y, '.-', color=style.BLUE, lw=1.2, markersize=3)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def draw_scene(base, panels, curve):
    """The panels of a scene beside each other, and its curve."""
    picture = drawing.draw_row([panel(base, *one) for one in panels], None, PANEL)
    if curve:
        picture = np.concatenate([picture, curve_picture(*curve(base), (
            picture.shape[1] // len(panels), picture.shape[0]))], axis=1)
    return picture


def facts(base, number):
    """Size and time of a run, and its number beside the reference."""
    with open(base + '.log', encoding='utf-8') as stream:
        log = stream.read()
    nodes, elements, dofs = re.search(
        r'^mesh +(\d+) nodes, (\d+) elements, (\d+) free dofs', log, re.M).groups()
    steps, solves = re.search(r'^(\d+) increments?, (\d+) iterations', log, re.M).groups()
    seconds = float(re.search(r'^processor time of all threads +([\d.]+)', log, re.M).group(1))
    what, found, wanted, _ = number(base)
    return (f'{int(dofs):,} dofs, {int(elements):,} elements, {steps} load steps, {solves} iterations, '
            f'{max(1, round(seconds))} s of processor time. **{what[0].upper() + what[1:]}: {found:.4g}**; '
            f'reference {wanted:.4g}, difference {100 * (found / wanted - 1):+.2g} %.')


def entry(name, deck, options, title, text, told):
    """The lines of a scene on the page."""
    return [f'## {title}', '', f'![{title}](gallery/{name}.png)', '', text, '', told, '',
            f'`{" ".join(["./mfec", deck] + options)}`', '']


def kept_facts(name):
    """What the page says of a scene today."""
    with open(os.path.join(HERE, 'gallery.md'), encoding='utf-8') as stream:
        page = stream.read()
    found = re.search(rf'gallery/{name}\.png\)\n\n.*\n\n(.*)\n', page)
    return found.group(1) if found else ''


def make_gallery(names):
    """Draws the scenes and writes the page."""
    from PIL import Image
    os.makedirs(GALLERY, exist_ok=True)
    lines = ['# Gallery', '', 'Made by `make gallery` from runs of the decks named below each picture; every '
             'number stands beside a reference, and a test holds both. Lengths and forces are mm and N where '
             'the deck says so. More fields, scales, views and movies: `mfec-post picture --help`.', '']
    digests = read_digests(GALLERY)
    with tempfile.TemporaryDirectory() as folder:
        for name, deck, options, panels, curve, number, title, text in scenes.SCENES:
            deck, path = deck_of(deck), os.path.join(GALLERY, name + '.png')
            told = kept_facts(name)
            if not names or name in names or not told:
                base = run(folder, deck, options)
                picture = Image.fromarray(draw_scene(base, panels, curve))
                picture.save(path, optimize=True, dpi=(300, 300))
                told = facts(base, number)
                digests[name] = scene_digest(deck, options, panels, number, curve)
                print(path)
            lines += entry(name, deck, options, title, text, told)
    with open(os.path.join(HERE, 'gallery.md'), 'w', encoding='utf-8') as stream:
        stream.write('\n'.join(lines).rstrip() + '\n')
    write_digests(GALLERY, {one[0]: digests[one[0]] for one in scenes.SCENES})


# ---- freshness ------------------------------------------------------------------------------


def digest_of(texts):
    """A short digest of some texts."""
    return hashlib.sha256('\0'.join(texts).encode()).hexdigest()[:16]


def figure_digest(name):
    """What a figure depends on: the procedure that draws it, its decks and their results."""
    figure = FIGURES[name]
    return digest_of([inspect.getsource(figure)] + getattr(figure, 'sources', []) + [
        part for deck in figure.decks for part in (deck_text(deck), numbers_of(deck))])


def scene_digest(deck, options, panels, number, curve):
    """What a picture of the gallery depends on: deck, meshes, results and what is drawn of them."""
    texts = [deck_text(deck), numbers_of(deck), ' '.join(options), str(panels), inspect.getsource(number)]
    texts += [inspect.getsource(curve)] if curve else []
    for path in meshes(deck):
        with open(path, 'rb') as stream:
            texts.append(hashlib.sha256(stream.read()).hexdigest())
    return digest_of(texts)


def numbers_of(deck):
    """The last rows of a deck's tables, three digits, as the regression tests hold them: a picture
    gets old when the program computes something else."""
    rows = []
    for case in sorted(glob.glob(os.path.join(TOP, 'tests', 'regression', '*', 'case'))):
        with open(case, encoding='ascii') as stream:
            if not re.search(rf'(?m)^deck .*/{re.escape(deck)}$', stream.read()):
                continue
        for table in sorted(glob.glob(os.path.join(os.path.dirname(case), '*.*'))):
            with open(table, encoding='ascii') as stream:
                last = stream.read().split('\n')[-2].split()
            values = [float(x) for x in last if re.fullmatch(r'[-+]?[\d.]+E[-+]?\d+', x)]
            size = max(map(abs, values), default=0.0)
            rows += [f'{x:.2e}' for x in values if abs(x) > 0.01 * size]
    return ' '.join(rows)


def read_digests(folder):
    """The digests that lie beside pictures."""
    path = os.path.join(folder, 'made_from.txt')
    if not os.path.exists(path):
        return {}
    with open(path, encoding='ascii') as stream:
        return dict(line.split() for line in stream)


def write_digests(folder, digests):
    """Writes the digests beside the pictures."""
    with open(os.path.join(folder, 'made_from.txt'), 'w', encoding='ascii') as stream:
        stream.writelines(f'{name} {digest}\n' for name, digest in sorted(digests.items()))


def stale():
    """Pictures that are missing, or older than what they show."""
    found = []
    for folder, wanted in ((PICTURES, {name: figure_digest(name) for name in FIGURES}),
                           (GALLERY, {s[0]: scene_digest(deck_of(s[1]), s[2], s[3], s[5], s[4])
                                      for s in scenes.SCENES})):
        kept = read_digests(folder)
        found += [os.path.join(os.path.basename(folder), name + '.png')
                  for name, digest in wanted.items()
                  if kept.get(name) != digest
                  or not os.path.exists(os.path.join(folder, name + '.png'))]
    return found


def make_figures(names):
    """Draws figures."""
    os.makedirs(PICTURES, exist_ok=True)
    digests = read_digests(PICTURES)
    plt = style.pyplot()
    plt.rcParams['savefig.dpi'] = 300
    with tempfile.TemporaryDirectory() as folder:
        for name in names or FIGURES:
            path = os.path.join(PICTURES, name + '.png')
            figure = FIGURES[name](folder, plt)
            if isinstance(figure, str):  # drawn already
                shutil.copyfile(figure, path)
            else:
                figure.savefig(path)
                plt.close(figure)
            digests[name] = figure_digest(name)
            print(path)
    write_digests(PICTURES, digests)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('names', nargs='*', help='figures; all without a name')
    parser.add_argument('--gallery', action='store_true')
    parser.add_argument('--stale', action='store_true')
    given = parser.parse_args()
    if given.stale:
        found = stale()
        print('\n'.join(found) or 'all pictures are fresh')
        return 1 if found else 0
    (make_gallery if given.gallery else make_figures)(given.names)
    return 0


if __name__ == '__main__':
    sys.exit(main())
