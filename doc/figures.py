#!/usr/bin/env python3
"""The figures of the manuals and the gallery, drawn from runs of the program.

    build/venv/bin/python doc/figures.py [NAME...]        figures into doc/pictures (all, or those named)
    build/venv/bin/python doc/figures.py --gallery        doc/gallery.md and doc/gallery/*.png
    build/venv/bin/python doc/figures.py --stale          names what is older than what it shows

Beside the pictures lies made_from.txt: for each picture a digest of the decks it was computed from
and of the procedure that drew it. A test wants these digests to be those of today's files.
"""
import argparse
import hashlib
import inspect
import os
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(HERE)
sys.path.insert(0, os.path.join(TOP, 'postproc'))
from mfec_post import Results, Surfaces, read_table, rows_of, scene, style  # noqa: E402

PICTURES = os.path.join(HERE, 'pictures')
GALLERY = os.path.join(HERE, 'gallery')


def deck_text(deck):
    """A deck of the tree."""
    with open(os.path.join(TOP, deck), encoding='ascii') as stream:
        return stream.read()


def run(folder, deck, options=(), changes=(), check=False):
    """Runs a deck with parts replaced; the base path of its files."""
    text = deck_text(deck)
    for old, new in changes:
        if old not in text:
            raise SystemExit(f'{deck} no longer holds: {old}')
        text = text.replace(old, new)
    work = tempfile.mkdtemp(dir=folder)
    base = os.path.join(work, 'x')
    for name in os.listdir(os.path.dirname(os.path.join(TOP, deck))):
        if name.endswith('.msh'):
            os.symlink(os.path.join(TOP, os.path.dirname(deck), name), os.path.join(work, name))
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
    with Results(base + '.h5') as results:
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
    figure, axes = plt.subplots(figsize=(6.4, 2.9))
    depth = np.abs(slave - tip).max()
    size = 0.14 * np.ptp(slave[:, 0]) / depth
    for k in range(0, len(tip), 2):
        gap = slave[k] - tip[k]
        end = tip[k] + size * gap
        colour = style.RED if status[k] == 2 else style.BLUE
        axes.annotate('', (end[0], end[2]), (tip[k][0], tip[k][2]), annotation_clip=False,
                      arrowprops={'arrowstyle': '-|>', 'color': colour, 'lw': 1.3, 'shrinkA': 0,
                                  'shrinkB': 0})
    axes.plot(tip[:, 0], tip[:, 2], '-', color=style.GREY, lw=1)
    axes.plot(tip[::2, 0], tip[::2, 2], 'o', color=style.INK, ms=3, label='tip on the facet')
    axes.plot([], [], color=style.BLUE, label='gap vector, stick')
    axes.plot([], [], color=style.RED, label='gap vector, slip')
    axes.set_aspect('equal')
    axes.set_xlabel('x')
    axes.set_ylabel('z')
    axes.set_ylim(-0.24, 0.06)
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.45), ncol=3)
    axes.set_title(f'a node slides over a kinked edge; gap vectors {size:.0f} times', fontsize=9)
    return figure


cone.decks = ['inputs/two_facet_edge.inp']


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
    bar = figure.colorbar(drawn, ax=all_axes, orientation='horizontal', fraction=0.06, pad=0.04)
    bar.set_label('pressure at the nodes; exact: 6.6858 everywhere (white: slave, dotted: master)')
    return figure


forms.decks = ['inputs/manual/two_meshes.inp']


def hosts(folder, plt):
    """The facet that holds the tip, along the way of a node over an edge."""
    base = run(folder, 'inputs/two_facet_edge.inp', ['--set', 'slope=0.2'])
    figure, axes = plt.subplots(figsize=(6.0, 3.4))
    with Results(base + '.h5') as results:
        pair = next(iter(results.pairs))
        index = {n: i for i, n in enumerate(results.node_numbers)}
        place, host, force = [], [], []
        for frame in range(results.steps):
            at = results.contact(pair, frame)
            x = results.points + results.point_field('displacement', frame)
            place.append(x[index[at['node'][0][0]]])
            host.append(at['host'][0])
            force.append(at['traction'][0])
        facets = np.array([[index[n] for n in f] for f in at['facets']])
    place, host, force = map(np.array, (place, host, force))
    colours = (style.BLUE, style.ORANGE, style.GREEN, style.RED)
    for k, facet in enumerate(facets):
        corners = x[np.append(facet, facet[0])]
        axes.fill(corners[:, 0], corners[:, 1], color=colours[k % 4], alpha=0.25)
        axes.plot(corners[:, 0], corners[:, 1], color=style.GREY, lw=0.8)
        mine = host == k + 1
        axes.plot(place[mine, 0], place[mine, 1], 'o', color=colours[k % 4], ms=4,
                  label=f'host: facet {k + 1}')
    size = 0.25 / np.abs(force[:, :2]).max()
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
        half = 0.35 * scene.facet_size(x, master.facets)
        axes.triplot(x[:, 0], x[:, 1], master.facets, color=style.GRID, lw=0.5)
        begin, end = x - half * lay, x + half * lay
        axes.plot([begin[:, 0], end[:, 0]], [begin[:, 1], end[:, 1]], color=style.GREEN, lw=1.2)
        axes.set_aspect('equal')
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

FIGURES = {f.__name__: f for f in (cone, ellipse, forms, hosts, lays, smooth)}

# ---- the gallery ----------------------------------------------------------------------------

# name, deck, options of the run, scene, what it is
SCENES = [
    ('cube', 'inputs/sliding_cube.inp', ['--set', 'phi=45'], 'bodies:mises',
     "The paper's cube, pressed on a block and pushed over it; the lay stands at 45°."),
    ('disc', 'inputs/manual/turned_disc.inp', [], 'master:status',
     'A block is led over a disc that was turned on a lathe: friction follows the grooves.'),
    ('hertz', 'inputs/sphere_on_plate.inp', [], 'slave:pressure',
     'A cap of a sphere, meshed by Gmsh, is pressed on a plate and slid: Hertz, and a gmsh part.'),
    ('lift', 'inputs/press_slide_lift_return.inp', [], 'bodies:mises',
     'A block is pressed, slid, lifted and put down again.'),
    ('pairs', 'inputs/two_cubes_block.inp', [], 'slave:shear_traction',
     'Two cubes on one base: two pairs with laws of their own.'),
    ('edge', 'inputs/two_facet_edge.inp', ['--set', 'slope=0.2'], 'bodies:displacement',
     'The tip of a body slides over a kinked edge.'),
    ('drum', 'inputs/manual/turning_pin.inp', [], 'bodies:displacement',
     'A pin is led around a drum of flat facets that `SMOOth` bends.'),
    ('patch', 'inputs/manual/cut_facets.inp', [], 'slave:pressure',
     'Meshes that do not match, cut by `SEGMent`: the same pressure everywhere.'),
]
WAITING = [('ironing', 'finite strain'), ('press fit', '`SHRInk`'), ('belt', 'finite strain'),
           ('O-ring', 'finite strain, nearly incompressible'), ('stack on a slope', '`GRAVity`'),
           ('ball in groove', '`RIGId` bodies with free unknowns'),
           ('partial slip and wedge', 'run as studies: [verification](verification.md)')]


def draw_scene(folder, deck, options, what):
    """The picture of a scene at its last end time."""
    base = run(folder, deck, options)
    kind, field = what.split(':')
    if kind == 'bodies':
        with Results(base + '.h5') as results:
            return scene.draw(scene.bodies(results, -1, field), None, 'matplotlib', (720, 544))
    with Surfaces(base + '.contact.vtkhdf') as surfaces:
        return scene.draw(scene.contact(surfaces, -1, field, None, kind), None, 'matplotlib',
                          (720, 544))


def make_gallery(names):
    """Draws the scenes and writes the page."""
    from PIL import Image
    os.makedirs(GALLERY, exist_ok=True)
    lines = ['# Gallery', '', 'Made by `make gallery` from decks of `inputs`; each is run by the '
             'tests. More colours, scales and movies: `mfec-post picture --help`.', '']
    digests = read_digests(GALLERY)
    with tempfile.TemporaryDirectory() as folder:
        for name, deck, options, what, text in SCENES:
            path = os.path.join(GALLERY, name + '.png')
            if not names or name in names:
                picture = draw_scene(folder, deck, options, what)
                Image.fromarray(picture).quantize(128).save(path, optimize=True)
                digests[name] = scene_digest(deck, options, what)
                print(path)
            command = ' '.join(['./mfec', deck] + options)
            lines += [f'## {text}', '', f'![{what.replace(":", ", ")}](gallery/{name}.png)', '',
                      f'`{command}`', '']
    lines += ['## Waiting', '', 'These want what this version does not have:', '',
              '| scene | waits for |', '|---|---|']
    lines += [f'| {scene_name} | {reason} |' for scene_name, reason in WAITING]
    with open(os.path.join(HERE, 'gallery.md'), 'w', encoding='utf-8') as stream:
        stream.write('\n'.join(lines) + '\n')
    write_digests(GALLERY, digests)


# ---- freshness ------------------------------------------------------------------------------


def digest_of(texts):
    """A short digest of some texts."""
    return hashlib.sha256('\0'.join(texts).encode()).hexdigest()[:16]


def figure_digest(name):
    """What a figure depends on: the procedure that draws it, and its decks."""
    figure = FIGURES[name]
    return digest_of([inspect.getsource(figure)] + [deck_text(deck) for deck in figure.decks])


def scene_digest(deck, options, what):
    """What a picture of the gallery depends on."""
    return digest_of([deck_text(deck), ' '.join(options), what])


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
                           (GALLERY, {s[0]: scene_digest(*s[1:4]) for s in SCENES})):
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
    plt.rcParams['savefig.dpi'] = 130
    with tempfile.TemporaryDirectory() as folder:
        for name in names or FIGURES:
            path = os.path.join(PICTURES, name + '.png')
            figure = FIGURES[name](folder, plt)
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
