"""Decks of strangers that once gave wrong numbers, or messages that led nowhere."""
import os
import shutil

import decks
from scene import table

HERE = os.path.dirname(os.path.abspath(__file__))
FOLDER = os.path.join(HERE, 'cases')
# A block of E A e = 160 and E/H = 250 in series with AUTO's 20 E over the height of its cells
PRESSED = -160.0/(1.0 + 250.0*0.5**0.5/20e3)
# deck, step and set, R3 and how exactly it is known; 11.4702 the joint's force without contact
VALUES = [('stl_inward', (2, 'top'), PRESSED, 1e-9),
          ('stl_one_flipped', (2, 'top'), PRESSED, 1e-9),
          ('seven_digits', (1, 'top'), -1000.0, 1e-6),
          ('half_bonded_reference_open', (4, 'ut'), 11.47021897261, 1e-9),
          ('half_bonded_tie_and_contact', (4, 'ut'), 11.47021897261, 1e-9),
          ('half_bonded_tie_and_contact', (2, 'ut'), -40.0, 0.01)]
WORDS = [('starts_inside', 1, ('start behind the master', 'as deep as 2.5')),
         ('never_touches', 0, ('pair ball was in contact at no output time',)),
         ('sector_two_planes', 1, ('model a quarter or half', 'SURFace name PLANe'))]
RIGID = '''MFEC * * a rigid part beside a block
MATErial 1 STEEL
  ELAStic ISOTropic 210000 0.3
MESH 'rigid_part_{kind}.inp'
BOUNdary
  Set-Bot 1 1 1
RIGId TOOL-1
  MOVE 0 0 -0.05
  TURN 0 0 1 0
CONTact
  PAIR 1
    GTOS Surf-Top Surf-Tool
PROPortional 1
  0 0
  1 1
OUTPut
  REACtions Set-Bot
  FIELds NONE
BATCh
 DT,,1
 STEP,,1
END
'''


def all_cases(program, report):
    """Each deck gives its value, or says what is wrong with it."""
    for name, row, wanted, limit in VALUES:
        with decks.fresh_folder() as folder:
            shutil.copytree(FOLDER, folder, dirs_exist_ok=True)
            done = decks.run(program, [name + '.inp', '--quiet'], folder, 120)
            found = table(folder, name)[row][2] if done.code == 0 else None
        good = found is not None and abs(found - wanted) <= limit*abs(wanted)
        report.add(f'case {name}, {row}', [] if good else
                   [f'{found}, {wanted} expected; exit code {done.code} {done.err[-300:]}'])
    for name, code, words in WORDS:
        with decks.fresh_folder() as folder:
            shutil.copytree(FOLDER, folder, dirs_exist_ok=True)
            done = decks.run(program, [name + '.inp'], folder, 120)
        missing = [w for w in words if w not in done.out + done.err]
        report.add(f'case {name}', [] if done.code == code and not missing else
                   [f'exit code {done.code}, not said: {missing}: {(done.out + done.err)[-500:]}'])
    forces = []
    for kind in ('r3d3', 'r3d4'):
        with decks.fresh_folder() as folder:
            shutil.copytree(FOLDER, folder, dirs_exist_ok=True)
            with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                out.write(RIGID.format(kind=kind))
            done = decks.run(program, ['x.inp', '--quiet'], folder, 120)
            forces.append(table(folder)[1, 'Set-Bot'][2] if done.code == 0 else done.err[-300:])
    # triangles and the halves of quadrilaterals are the same plane
    good = all(isinstance(f, float) and f > 1e4 for f in forces)
    good = good and abs(forces[0] - forces[1]) < 1e-9*abs(forces[0])
    report.add('case rigid parts of triangles and quadrilaterals', [] if good else [str(forces)])
