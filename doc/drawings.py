#!/usr/bin/env python3
"""Drawings of the contact chapter and sketches of verification cases, as vectors: doc/pictures/contact_*.svg
and doc/verification/sketch_*.svg (make figures).

    build/venv/bin/python doc/drawings.py
"""
import os

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'pictures')
SLAVE, MASTER, POINT, ACCENT = '#0072b2', '0.35', '#d55e00', '#009e73'
plt.rcParams.update({'svg.fonttype': 'none', 'svg.hashsalt': 'mfec', 'font.size': 9})


def axes(count, width=8.0, height=2.9):
    """A row of empty drawings."""
    figure, row = plt.subplots(1, count, figsize=(width, height), layout='constrained', squeeze=False)
    for one in row[0]:
        one.set_aspect('equal')
        one.axis('off')
    return figure, list(row[0])


def save(figure, name):
    """One file."""
    figure.savefig(os.path.join(FOLDER, f'contact_{name}.svg'), metadata={'Date': None}, bbox_inches='tight', pad_inches=0.04)
    plt.close(figure)


def arrow(one, start, end, color, text='', at=(0, 0), **more):
    """An arrow with a word beside its end."""
    one.plot(*zip(start, end), alpha=0)  # an arrow does not widen the axes
    one.annotate('', xy=end, xytext=start, arrowprops={'arrowstyle': '-|>', 'color': color, 'lw': 1.4, **more})
    if text:
        one.text(end[0] + at[0], end[1] + at[1], text, color=color, ha='center', va='center')


def surfaces(one, slave, master, gap=0.35):
    """Two meshes, one over the other: the places of their nodes."""
    for places, height, sign, color in ((slave, gap, 1, SLAVE), (master, 0.0, -1, MASTER)):
        one.fill_between([places[0], places[-1]], height, height + sign*0.45, color=color, alpha=0.12, lw=0)
        one.plot(places, [height]*len(places), '-', color=color, lw=2)
        for x in places:
            one.plot([x, x], [height, height + sign*0.45], '-', color=color, lw=0.7)
            one.plot(x, height, 'o', color=color, ms=4)


def forms():
    """Where the points of the three forms lie."""
    figure, row = axes(3)
    slave, master = np.array([0, 0.9, 1.8, 2.7]), np.array([0, 0.6, 1.3, 2.0, 2.7])
    points = {'NTOS': slave,
              'GTOS': np.concatenate([a + 0.9*np.array([1/6, 1/2, 5/6]) for a in slave[:-1]])}
    cuts = np.unique(np.concatenate([slave, master]))
    points['GTOS ... SEGMent'] = np.concatenate([a + (b - a)*np.array([1/6, 1/2, 5/6]) for a, b in zip(cuts, cuts[1:])])
    for one, (name, places) in zip(row, points.items()):
        surfaces(one, slave, master)
        if 'SEG' in name:
            for x in cuts:
                one.plot([x, x], [0, 0.35], ':', color='0.6', lw=0.8)
        for x in places:
            one.plot([x, x], [0.02, 0.35], '-', color=POINT, lw=0.6)
            one.plot(x, 0.35, 'D', color=POINT, ms=3.5)
        one.set_title(name)
        one.text(1.35, 0.92, 'slave', color=SLAVE, ha='center')
        one.text(1.35, -0.62, 'master', color=MASTER, ha='center')
        one.set(ylim=(-0.75, 1.05))
    save(figure, 'forms')


def sides():
    """Only points of the slave are watched."""
    figure, row = axes(2)
    for one, title, slave in ((row[0], 'finer side slave: all is seen', True), (row[1], 'coarser side slave: an edge goes in between', False)):
        fine, coarse = np.array([0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8]), np.array([0, 1.8])
        dent = np.array([0, 0, 0, -0.16, 0, 0, 0]) if not slave else np.zeros(7)
        one.fill_between(fine, 0.04 + dent, 0.6, color=SLAVE if slave else MASTER, alpha=0.15, lw=0)
        one.plot(fine, 0.04 + dent, 'o-', color=SLAVE if slave else MASTER, ms=4)
        one.fill_between(coarse, -0.5, 0.0, color=MASTER if slave else SLAVE, alpha=0.15, lw=0)
        one.plot(coarse, [0, 0], 's-', color=MASTER if slave else SLAVE, ms=5)
        one.text(0.9, 0.42, 'slave' if slave else 'master', ha='center', color=SLAVE if slave else MASTER)
        one.text(0.9, -0.36, 'master' if slave else 'slave', ha='center', color=MASTER if slave else SLAVE)
        one.set_title(title)
    save(figure, 'sides')


def penalty():
    """Force over gap: what a penalty allows, and what multipliers do."""
    figure, row = plt.subplots(1, 2, figsize=(8, 2.9), layout='constrained')
    gap = np.array([-1, 0, 0.6])
    row[0].plot(gap, [1, 0, 0], color=MASTER, label='soft')
    row[0].plot([-0.25, 0, 0.6], [1, 0, 0], color=SLAVE, label='AUTO')
    row[0].plot([0, 0, 0.6], [1, 0, 0], '--', color=POINT, label='AUGMent')
    row[0].set(xlabel='gap (negative: penetration)', ylabel='normal force', xticks=[0], yticks=[0], title='normal')
    slip = np.array([-1.2, -0.4, 0.4, 1.2])
    row[1].plot(slip, [-1, -1, 1, 1], color=SLAVE, label='AUTO')
    row[1].plot([-1.2, 0, 0, 1.2], [-1, -1, 1, 1], '--', color=POINT, label='AUGMent')
    row[1].set(xlabel='tangential displacement', ylabel='friction', xticks=[0], yticks=[-1, 0, 1], title='tangential')
    row[1].set_yticklabels(['−μN', '0', 'μN'])
    row[1].annotate('elastic slip\nμN / penalty', (0.4, 1), (0.75, 0.05), ha='center', arrowprops={'arrowstyle': '->', 'lw': 0.8})
    for one in row:
        one.legend(frameon=False, fontsize=8)
        one.spines[['top', 'right']].set_visible(False)
    save(figure, 'penalty')


def helix(one, phi, bore):
    """Half of a cylinder seen from the side that is in contact, its lay at an angle."""
    color = ACCENT
    for y in np.linspace(-0.95, 0.95, 6):
        one.plot([-1, 1], [y, y], ':', color='0.75', lw=0.7)
    for c in np.linspace(-1.6, 1.6, 9):
        x = np.linspace(-1, 1, 60)
        slope = np.tan(np.radians(phi))
        y = c + slope*x
        inside = np.abs(y) < 1
        one.plot(x[inside], y[inside], color=color, lw=1.2)
    one.plot([-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1], color=MASTER, lw=1.5)
    arrow(one, (0, -1.35), (0, 1.5), MASTER, 'axis a', (0.32, 0), linestyle='--')
    way = -0.8 if bore else 0.8
    arrow(one, (0, 0), (way, 0), POINT, 'a x r', (0, -0.16))
    end = (way*np.cos(np.radians(phi)), way*np.sin(np.radians(phi)))
    arrow(one, (0, 0), end, color, 'lay', (0, 0.17*np.sign(end[1] or 1)))


def lay():
    """The sign of the angle on a shaft and in a bore: about the outward normal, towards the reader."""
    figure, row = axes(2, 7.5, 3.8)
    for one, bore, title in ((row[0], False, 'shaft: seen from outside'), (row[1], True, 'bore: seen from its axis')):
        helix(one, 30, bore)
        one.set_title(title + '\nANGLe 30 CIRCumferential', fontsize=9)
        one.text(0, -1.6, 'right-handed thread' if not bore else 'left-handed thread', ha='center')
        one.plot(0, 0, 'o', mfc='w', mec='k', ms=9)
        one.plot(0, 0, 'k.', ms=4)
        one.set(xlim=(-1.4, 1.4), ylim=(-1.75, 1.65))
    save(figure, 'lay')


def carrier():
    """The master carries the lay: with it, or fixed in space."""
    figure, row = axes(3, 8, 3.0)
    for one, angle, along, title in ((row[0], 0, 0, 'start'), (row[1], 40, 40, 'DIREction MATErial ...\nturns with the master'),
                                     (row[2], 40, 0, 'DIREction ...\nstands still in space')):
        t = np.radians(angle)
        turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
        square = turn @ np.array([[-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]])
        one.fill(*square, color=MASTER, alpha=0.15)
        one.plot(*square, color=MASTER)
        s = np.radians(along)
        for c in np.linspace(-0.75, 0.75, 6):
            middle = np.array([-np.sin(s), np.cos(s)])*c
            reach = np.array([np.cos(s), np.sin(s)])*0.85
            one.plot(*np.array([middle - reach, middle + reach]).T, color=ACCENT, lw=1.2)
        one.plot(*(0.22*np.array([[-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]]) + [[0.3], [0.0]]), color=SLAVE, lw=1.6)
        one.text(0.3, 0, 'slave', color=SLAVE, fontsize=7, ha='center', va='center', bbox={'fc': 'w', 'ec': 'none', 'pad': 0.5})
        one.set_title(title, fontsize=9)
    save(figure, 'carrier')


def hatch(one, x, y):
    """A side that is held."""
    one.plot(x, y, color='k', lw=1.2)
    for t in np.linspace(0.02, 0.94, 9):
        at = np.array([x[0] + t*(x[1] - x[0]), y[0] + t*(y[1] - y[0])])
        one.plot([at[0], at[0] - 0.07], [at[1], at[1] - 0.08], color='k', lw=0.6)


def body(one, x, y, color, name=''):
    """A body with its name in the middle."""
    one.fill(x, y, color=color, alpha=0.15)
    one.plot([*x, x[0]], [*y, y[0]], color=color, lw=1.3)
    if name:
        one.text((min(x) + max(x))/2, (min(y) + max(y))/2, name, ha='center', va='center', color=color, fontsize=8)


def circle(r, middle=(0, 0), start=0.0, end=360.0):
    """Points of an arc."""
    t = np.radians(np.linspace(start, end, 80))
    return middle[0] + r*np.cos(t), middle[1] + r*np.sin(t)


def sketch_wedge(one):
    body(one, [-1, 1.2, 1.2], [0, 0, 0.8], MASTER, '')
    body(one, [-0.4, 0.4, 0.19, -0.61], [0.22, 0.51, 1.05, 0.76], SLAVE)
    arrow(one, (-1.2, 0.6), (-0.55, 0.6), POINT, 'F', (-0.4, 0.15))
    arrow(one, (-0.1, 0.95), (-0.1, 0.45), POINT, 'G', (0.14, 0.12))
    hatch(one, [-1, 1.2], [0, 0])


def sketch_hertz_roller(one):
    body(one, *circle(0.7, (0, 0.7)), SLAVE, 'R 50')
    body(one, [-1.2, 1.2, 1.2, -1.2], [0, 0, -0.8, -0.8], MASTER, 'block')
    arrow(one, (0, 1.9), (0, 1.42), POINT, '35 kN/mm', (0.5, 0.35))
    hatch(one, [-1.2, 1.2], [-0.8, -0.8])


def sketch_rounded_punch(one):
    arc = circle(0.1, (0.4, 0.1), 270, 360)
    right = np.array([np.append(arc[0], 0.5), np.append(arc[1], 1.0)])
    body(one, np.concatenate([right[0], -right[0][::-1]]), np.concatenate([right[1], right[1][::-1]]), SLAVE, 'steel\nD 100, H 100')
    body(one, [-1, 1, 1, -1], [0, 0, -1.2, -1.2], MASTER, 'aluminium, D 200, H 200')
    for x in np.linspace(-0.4, 0.4, 5):
        arrow(one, (x, 1.28), (x, 1.02), POINT)
    one.text(0.62, 1.15, '100 MPa', color=POINT)
    one.text(0.62, 0.12, 'fillet 10', fontsize=8)
    hatch(one, [-1, 1], [-1.2, -1.2])


def sketch_flat_punch(one):
    body(one, [-0.5, 0.5, 0.5, -0.5], [0, 0, 0.4, 0.4], SLAVE, 'rigid, 2 a')
    body(one, [-1.3, 1.3, 1.3, -1.3], [0, 0, -0.9, -0.9], MASTER, 'half-plane')
    arrow(one, (0, 0.9), (0, 0.42), POINT, 'P', (0.15, 0.4))
    arrow(one, (0.5, 0.2), (1.0, 0.2), POINT, 'slides', (0.1, 0.13))


def sketch_line_partial_slip(one):
    body(one, *circle(0.7, (0, 0.7), 200, 340), SLAVE, '')
    body(one, *circle(0.7, (0, -0.7), 20, 160), MASTER, '')
    arrow(one, (0, 1.1), (0, 0.6), POINT, 'P', (0.15, 0.4))
    arrow(one, (0.2, 0.5), (0.8, 0.5), POINT, 'Q', (0.1, 0.12))
    one.text(0, -0.35, 'equal cylinders', color=MASTER, ha='center', fontsize=8)


def sketch_rolling(one):
    body(one, *circle(0.7, (0, 0.7)), SLAVE, 'R')
    body(one, [-1.3, 1.3, 1.3, -1.3], [0, 0, -0.6, -0.6], MASTER, 'half-plane')
    one.plot(*circle(0.9, (0, 0.7), 60, 120), color=POINT, lw=1.4)
    arrow(one, (0.40, 1.5), (0.48, 1.46), POINT)
    arrow(one, (0.8, 0.7), (1.3, 0.7), POINT, 'Q', (0.0, 0.14))
    arrow(one, (0, 1.35), (0, 1.0), POINT, 'P', (0.13, 0.2))


def sketch_band_on_cylinder(one):
    body(one, *circle(0.7), MASTER, 'drum')
    one.plot(*circle(0.75, start=0, end=180), color=SLAVE, lw=3)
    for x, name in ((-0.75, 'T1'), (0.75, 'T2')):
        arrow(one, (x, 0), (x, -0.9), SLAVE, name, (0, -0.15))


def sketch_raous_plate(one):
    body(one, [-1, 1, 1, -1], [0, 0, 1, 1], SLAVE, '40 x 40')
    for x in np.linspace(-0.9, 0.9, 7):
        arrow(one, (x, 1.3), (x, 1.03), POINT)
    for y in np.linspace(0.1, 0.9, 4):
        arrow(one, (-1.3, y), (-1.03, y), POINT)
    hatch(one, [-1.2, 1.2], [0, 0])


def sketch_concentric_rings(one):
    for r, color in ((1.1, MASTER), (0.75, SLAVE)):
        one.plot(*circle(r), color=color)
    for r in (0.5,):
        one.plot(*circle(r), color=SLAVE)
    for angle in range(0, 360, 45):
        t = np.radians(angle)
        arrow(one, (0.25*np.cos(t), 0.25*np.sin(t)), (0.48*np.cos(t), 0.48*np.sin(t)), POINT)
    one.text(0, 0.9, 'master', color=MASTER, ha='center', fontsize=8)
    one.text(0, 0.6, 'slave', color=SLAVE, ha='center', fontsize=8)


def sketch_shear_lag_bar(one):
    body(one, [-1.3, 1.1, 1.1, -1.3], [0, 0, 0.15, 0.15], SLAVE, '')
    for x in np.linspace(-1.2, 1.0, 8):
        arrow(one, (x, 0.42), (x, 0.17), POINT)
    arrow(one, (1.1, 0.075), (1.6, 0.075), POINT, 'F', (-0.1, 0.16))
    hatch(one, [-1.4, 1.4], [0, 0])


def sketches():
    """One a case, named after its page."""
    for name, draw in list(globals().items()):
        if name.startswith('sketch_'):
            figure, row = axes(1, 3.4, 2.6)
            draw(row[0])
            figure.savefig(os.path.join(FOLDER, '..', 'verification', name + '.svg'), metadata={'Date': None})
            plt.close(figure)


if __name__ == '__main__':
    for drawing in (forms, sides, penalty, lay, carrier, sketches):
        drawing()
