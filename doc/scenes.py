"""The scenes of the gallery: deck, pictures, and one number of each against a reference.

A number is (what, found, reference, most that they may differ by); it is computed from the files of a
run, and the tests hold both the number and what doc/gallery.md says of it.
"""
import math

import numpy as np
from mfec_post import Results, Surfaces, read_table, rows_of

FRONT, ABOVE, BEHIND, SIDE = (-60.0, 24.0), (-60.0, 50.0), (120.0, 24.0), (-70.0, 12.0)


def rows(base, ending, name):
    """Rows of a set, pair or body of a table."""
    return rows_of(read_table(base + ending), name)


def sliding_cube(base):
    """T/N of a cube that slides at 45 degrees to the lay, on a flat base: the friction ellipse."""
    row = rows(base, '.rea', 'top')[-1]
    return ('friction over normal force', math.hypot(row['R1'], row['R2']) / abs(row['R3']),
            0.1 * 0.08 / math.hypot(0.1 * math.sqrt(0.5), 0.08 * math.sqrt(0.5)), 0.01)


def lap_joint(base):
    """Load of gross slip: Coulomb's friction of the forces between the plates and under the head."""
    pulled, faying, head = rows(base, '.rea', 'pulled'), rows(base, '.con', 'faying'), rows(base, '.con', 'under_head')
    slides = (faying['stick'] == 0) & (faying['time'] > 1.05) & (faying['time'] < 1.5)
    wanted = 0.2 * (faying['Fn'] + head['Fn'])[slides].mean()
    return 'load of gross slip [N]', pulled['R1'][slides].mean(), wanted, 0.01


def brake(base):
    """Brake torque over force: friction across a lay at 35 degrees, on the mean radius of the pad."""
    last = rows(base, '.con', 'pad_on_disc')[-1]
    friction = 1 / math.hypot(math.cos(math.radians(35)) / 0.45, math.sin(math.radians(35)) / 0.3)
    arm = 2 / 3 * (100**3 - 70**3) / (100**2 - 70**2)
    return 'torque over force [mm]', last['M3'] / last['Fn'], friction * arm, 0.01


def push_out(base):
    """Push-out force: Coulomb's friction of Lame's pressure of two rings in plane stress."""
    a, b, c, young = 10.0, 20.0, 32.0, 210000.0  # Poisson's ratio falls out: one material
    compliance = b / young * ((c**2 + b**2) / (c**2 - b**2) + (b**2 + a**2) / (b**2 - a**2))
    wanted = 0.12 * 0.02 / compliance * 2 * math.pi * b * 20 / 4
    return 'push-out force of the quarter [N]', rows(base, '.rea', 'pushed')['R3'][-1], wanted, 0.03


def seal(base):
    """Force of the squeezed ring without friction: Lindley's formula, a fit to measurements."""
    squeeze, thick, ring, young = 0.2, 4.0, 20.0, 5.0
    wanted = math.pi * ring * thick * young * (1.25 * squeeze**1.5 + 50 * squeeze**6)
    return 'force of the ring [N]', 4 * rows(base, '.con', 'on_floor')['Fn'][-1], wanted, 0.05


def snap_fit(base):
    """Largest force of insertion: a beam's force on a ramp that turns with the beam."""
    young, inertia, rise, length, mu = 2000.0, 4.0 * 2**3 / 12, 1.5, 25.0, 0.2
    lift = 3 * young * inertia * rise / length**3
    slope = math.tan(math.atan(0.5) + 1.5 * rise / length)
    wanted = lift * (mu + slope) / (1 - mu * slope)
    return ('force of insertion [N]', 2 * np.abs(rows(base, '.rea', 'catch')['R1']).max(), wanted,
            0.1)


def tyre(base):
    """Rolling radius over the radius at rest."""
    found = rows(base, '.rig', 'rim')
    start, last = found[found['time'] == 1.0][0], found[-1]
    turned = abs(last['ROT2'] - start['ROT2'])
    return 'rolling radius', (last['U1'] - start['U1']) / turned, 1.0, 0.01


def fretting(base):
    """Half width of the part that sticks over that of the contact: Cattaneo and Mindlin."""
    at = list(read_table(base + '.con')['time'])
    k = int(np.argmin(np.abs(np.array(at) - 2.0)))
    with Surfaces(base + '.contact.vtkhdf') as surfaces:
        part = surfaces.surface('cylinder_on_flat', 'slave', k)
    sums = read_table(base + '.con')[k]
    areas = part.areas
    touches = (part.at_facets['stick_share'] + part.at_facets['slip_share']) @ areas
    sticks = part.at_facets['stick_share'] @ areas
    wanted = math.sqrt(1 - abs(sums['F1']) / (0.6 * sums['Fn']))
    return 'stick over contact width', sticks / touches, wanted, 0.04


def gears(base):
    """Arm of the force of the flanks about the axis of the drive: the base circle of the involute."""
    last = read_table(base + '.con')[-1]
    return ('arm of the flank force [mm]', last['M3'] / math.hypot(last['F1'], last['F2']),
            50 * math.cos(math.radians(20)), 0.002)


def ironing_deep(base):
    """Pull: an elastic strip gives back what it takes, so the pull is the work of friction over the way."""
    table = read_table(base + '.con')
    late = table['time'] > 1.5
    with Results(base + '.vtkhdf') as results:
        names = [name.decode().strip() for name in results.file['audit/sum_names'][:]]
        lost = results.file['audit/sums'][:, names.index('dissipation')][late]
    way = 10 * np.ptp(table['time'][late])
    return 'pull [N]', np.abs(table['F1'][late])[1:].mean(), (lost[-1] - lost[0]) / way, 0.05


def stack_on_slope(base):
    """Force along the slope in the lowest joint over the weight of one block: statics."""
    last = rows(base, '.con', 'first_on_slope')[-1]
    slope = np.array([math.cos(math.radians(12)), 0, math.sin(math.radians(12))])
    return ('force along the slope over weight', abs(np.array([last[f'F{k}'] for k in (1, 2, 3)]) @ slope),
            3 * math.sin(math.radians(12)), 1e-4)


def belt(base):
    """Force of the drawn end over that of the other: the capstan."""
    return ('ratio of the forces', abs(rows(base, '.rea', 'pulled')['R3'][-1]),
            math.exp(0.3 * math.pi), 0.05)




def fretting_loop(base):
    """Tangential force of the cylinder over its displacement."""
    found = rows(base, '.rea', 'lid')
    push = 0.012 * np.interp(found['time'], [0, 1, 2, 4, 6], [0, 0, 1, -1, 1])
    return 1000 * push, found['R1'], 'displacement of the cylinder [µm]', 'tangential force [N]'


def snap_curve(base):
    """Force of the catch over its displacement."""
    found = rows(base, '.rea', 'catch')
    return 10 * found['time'], -2 * found['R1'], 'displacement of the catch [mm]', 'its force [N]'


def slip_curve(base):
    """Load of the joint over its displacement."""
    found = rows(base, '.rea', 'pulled')
    late = found['time'] >= 1.0
    return (0.5 * (found['time'][late] - 1), found['R1'][late] / 1000, 'displacement [mm]',
            'load of the joint [kN]')


# Name, deck, options, panels (what is drawn, output time, view), curve, number, title, what it shows.
SCENES = [
    ('sliding_cube', 'sliding_cube', ['--set', 'phi=45'],
     [('bodies:mises', -1, FRONT), ('slave:pressure', -1, None)], None, sliding_cube,
     'A cube slides across the lay',
     'A cube is pressed on a block whose friction is elliptical (0.1 along the lay, 0.08 across) and '
     'pushed at 45° to the lay. The reference is the friction ellipse on a flat rigid base.'),
    ('lap_joint', 'gallery/lap_joint', [],
     [('bodies:mises', 10, ABOVE), ('slave:pressure:faying', 1, None)], slip_curve, lap_joint,
     'A bolted lap joint slips into bearing',
     'A bolt in a hole with 0.2 mm of clearance clamps two plates by SHRInk; the joint is pulled until '
     'the plates slide, between each other and under the heads, and the shank meets the holes. The '
     'reference is Coulomb friction of what presses then, 10.12 kN between the plates and 10.65 kN under '
     'the head. Before the pull it is 11.12 and 11.08 kN, whose friction is 7 % more: the pull acts in two '
     'planes 8 mm apart, and the held ends carry its couple by 0.53 kN across the plates, which comes off '
     'the force between them; and the bolt, which leans, loses 4 %.'),
    ('brake', 'gallery/brake', [],
     [('mesh', -1, ABOVE), ('master:pressure', -1, None)], None, brake,
     'A brake disc with its ground lay',
     'The lay stands at 35° to the circumference and turns with the disc; friction is 0.45 along it and '
     '0.3 across. The pressure leans to the edge that the disc runs in at. The reference is the '
     'friction ellipse at 35° times the mean radius of an evenly pressed pad.'),
    ('push_out', 'gallery/push_out', [],
     [('bodies:mises', 3, FRONT), ('master:pressure', 3, None)], None, push_out,
     'Press fit and push-out',
     'A bush is shrunk on a hollow shaft of the same steel (SHRInk), which is then pushed out. '
     'The reference is Coulomb friction of Lamé\'s pressure for plane stress.'),
    ('seal', 'gallery/seal', ['--set', 'mu=0'],
     [('bodies:mises', -1, FRONT), ('slave:pressure', -1, (-120.0, 35.0))], None, seal,
     'An O-ring is squeezed by 20 %',
     'Neo-Hookean rubber with Poisson\'s ratio 0.49 between exact planes, without friction. The reference is '
     'Lindley\'s formula, a fit to measurements on lubricated rubber. Over the squeeze the difference falls from '
     '+14 % at 8 % to -2 % at 20 %, for the formula starts with a power 1.5 and a line contact does not. '
     'Friction is what stiffens a ring: with 0.2 the force is 177 N, 26 % more; Poisson\'s ratio 0.499 adds '
     '0.8 %.'),
    ('snap_fit', 'gallery/snap_fit', [],
     [('bodies:mises', 12, SIDE), ('bodies:mises', 27, SIDE)], snap_curve, snap_fit,
     'A snap fit',
     'A hook on an elastic arm is pushed past an exact cylinder: it rises on its ramp, slides over the '
     'ridge and snaps in, where the force changes its sign. The reference is the force of a beam on a '
     'ramp with friction, the ramp turned as the end of the beam is.'),
    ('tyre', 'gallery/tyre', [],
     [('bodies:mises', -1, SIDE), ('slave:pressure', -1, (-50.0, -30.0))], None, tyre,
     'A solid tyre rolls',
     'Rubber on a rigid rim is pressed on the road and drawn by its axle; friction alone turns it. '
     'The reference is the radius at rest. A bonded cover that is nearly incompressible stretches in the '
     'nip, so such a roll runs as if it were a little larger, though its axle sinks by 0.04; a pneumatic '
     'tyre runs as if it were smaller.'),
    ('fretting', 'gallery/fretting', [],
     [('bodies:mises', 11, (-90.0, 0.0)), ('slave:status', 11, None)], fretting_loop, fretting,
     'Fretting: partial slip and its loop',
     'A cylinder is pressed on a flat and pushed to and fro by less than friction holds. The middle '
     'sticks, the rims slip, and force over displacement is a loop whose area friction takes. The '
     'reference is Cattaneo\'s and Mindlin\'s width of the part that sticks. The difference is that of the '
     'mesh: -8.2, -3.4 and -1.2 % with 40, 80 and 160 cells along the fine part.'),
    ('gears', 'gallery/gears', [],
     [('bodies:mises', -1, (-90.0, 60.0)), ('slave:pressure', -1, (180.0, 20.0))], None, gears,
     'Teeth of two gears',
     'Involute flanks of ten-node elements; the drive is turned against the driven gear, without '
     'friction. The reference is geometry: the force of the flanks is tangential to the base circle.'),
    ('ironing', 'gallery/ironing_deep', [],
     [('bodies:mises', 5, (-80.0, 14.0)), ('bodies:mises', -1, (-80.0, 14.0))], None, ironing_deep,
     'Ironing of a rubber strip',
     'An exact cylinder is pressed into a strip by a sixth of its thickness and drawn over it. '
     'The reference is the energy that friction takes over the path of the tool: elastic rubber gives '
     'back the rest.'),
    ('stack', 'gallery/stack_on_slope', [],
     [('bodies:mises', -1, FRONT), ('master:pressure:first_on_slope', -1, None)], None, stack_on_slope,
     'A stack on a slope',
     'Three blocks that nothing but friction holds. The reference is statics.'),
    ('belt', 'gallery/belt', [],
     [('bodies:mises', -1, SIDE), ('slave:pressure', -1, (-60.0, 40.0))], None, belt,
     'A belt around a drum',
     'A force on one end of a belt, the other end is drawn until the belt slips. The reference is the '
     'capstan, exp(µπ); half of the difference is the thickness of the belt, half its cells.'),
]
