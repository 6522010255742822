#!/usr/bin/env python3
"""The keyword pages, A to Z, from the keyword table of the program and the decks that use the words.

    doc/keywords.py [--program ./mfec]         names the pages that are not what the program says
    doc/keywords.py [--program ./mfec] --fix   writes doc/keywords.md and doc/keywords/*.md

Syntax, parameters and explanation are those of `mfec --help KEYWORD`; the example is a piece of the
shortest deck that has the word; meaning, unit and default of parameters stand below.
"""
import glob
import os
import re
import subprocess
import sys

from renewed import is_old

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MOST_LINES = 14  # of an example
FOLDER = os.path.join(TOP, 'doc', 'keywords')
# Name of a parameter, or of it in one keyword: meaning, unit, default.
PARAMETERS = {
    'mu': ('coefficient of friction', '1', ''), 'mu1': ('coefficient along the lay', '1', ''),
    'mu2': ('coefficient across the lay', '1', ''), 'mk1': ('kinetic coefficient along the lay', '1', ''),
    'mk2': ('kinetic coefficient across the lay', '1', ''),
    'DECAy length': ('slip path over which the coefficients decay', 'length', ''),
    'tau': ('largest shear traction', 'force/length²', ''),
    'PENAlty epsilon': ('penalty of each point; with AREA per area', 'force/length; force/length³', ''),
    'factor': ('penalty over E/h of the softer side', '1', 'without it, 20 times the stiffness of the layer that is pressed'),
    'points': ('quadrature points in each facet', '', '3; 6 on facets of six nodes'),
    'tol': ('tolerance', '', ''), 'AUGMent tol': ('gap over facet, change of forces over the largest', '1', '1e-6'),
    'max': ('most updates of multipliers', '', '25; with GTOS 50'),
    'tolerance': ('largest gap or penetration that is closed', 'length', 'chordal deviation of the facets there, 1e-3 to 1/20 of a facet'),
    'radius': ('radius of the search for a facet', 'length', 'longest edge of the master'),
    'E': ("Young's modulus", 'force/length²', ''), 'nu': ("Poisson's ratio", '1', ''), 'rho': ('density', 'mass/length³', ''),
    'x': ('point of an axis, or centre', 'length', ''), 'y': ('the same', 'length', ''), 'z': ('the same', 'length', ''),
    'x1': ('coordinate', 'length', ''), 'x2': ('coordinate', 'length', ''), 'x3': ('coordinate', 'length', ''),
    'BOX x1': ('limits along x1, with x2', 'length', ''), 'y1': ('limits along x2', 'length', ''), 'y2': ('limits along x2', 'length', ''),
    'z1': ('limits along x3', 'length', ''), 'z2': ('limits along x3', 'length', ''),
    'a1': ('direction of an axis', '', ''), 'a2': ('the same', '', ''), 'a3': ('the same', '', ''),
    'v1': ('direction of the lay', '', '1'), 'v2': ('the same', '', '0'), 'v3': ('the same', '', '0'),
    'phi': ('rotation of the lay about the outward normal of the master', 'degree', '0'), 'angle': ('angle of rotation', 'degree', ''),
    'u1': ('prescribed displacement along x1', 'length', ''), 'u2': ('the same along x2', 'length', ''),
    'u3': ('the same along x3', 'length', ''), 'f1': ('force along x1', 'force', ''), 'f2': ('the same along x2', 'force', ''),
    'f3': ('the same along x3', 'force', ''), 'm1': ('moment about x1', 'force · length', ''), 'm2': ('the same about x2', 'force · length', ''),
    'm3': ('the same about x3', 'force · length', ''), 'k1': ('stiffness along x1 of each node', 'force/length', ''),
    'k2': ('the same along x2', 'force/length', ''), 'k3': ('the same along x3', 'force/length', ''),
    't1': ('traction along x1', 'force/length²', ''), 't2': ('the same along x2', 'force/length²', ''), 't3': ('the same along x3', 'force/length²', ''),
    'g1': ('acceleration along x1', 'length/time²', ''), 'g2': ('the same along x2', 'length/time²', ''),
    'g3': ('the same along x3', 'length/time²', ''), 'd': ('translation along x1, x2 and x3', 'length', ''),
    'code1': ('0 free, else restrained, along x1', '', ''), 'code2': ('the same along x2', '', ''), 'code3': ('the same along x3', '', ''),
    'p1': ('number of the load along x1', '', '0: the sum of all'), 'p2': ('the same along x2', '', '0'), 'p3': ('the same along x3', '', '0'),
    't': ('time', 'time', ''), 'p': ('value of the load at t', '1', ''), 'PRESsure p': ('pressure, positive inwards', 'force/length²', ''),
    'table': ('number of a load (PROPortional)', '', '0: the sum of all'), 'SHRInk table': ('number of a load: the share that counts', '', ''),
    'number': ('its number', '', ''), 'name': ('its name', '', ''), 'label': ('name of the regions that have it', '', 'its number'),
    'set': ('a set, region or surface', '', ''), 'surface': ('a surface', '', ''), 'region': ('a region', '', ''),
    'slave': ('set or surface whose points may not penetrate', '', ''), 'master': ('surface that they may not penetrate', '', ''),
    'node': ('number of a node', '', ''), 'inc': ('0, or step of the numbers up to the next record', '', '0'),
    'element': ('number of an element', '', ''), 'material': ('number of a material', '', ''), 'file': ('name of a file', '', ''),
    'direction': ('1, 2 or 3', '', ''), 'coordinate': ('its value', 'length', ''), 'PLANe tol': ('distance that counts as in the plane', 'length', 'round-off'),
    'n': ('a number', '', ''), 'n1': ('cells, or number, in the first direction', '', ''), 'n2': ('the same, second', '', ''),
    'n3': ('the same, third', '', ''), 'v': ('value', '', ''), 'DT v': ('size of a load step', 'time', ''), 'r': ('radius; negative: a bore', 'length', ''),
    'nx': ('outward normal', '', ''), 'ny': ('the same', '', ''), 'nz': ('the same', '', ''), 'ax': ('direction of the axis', '', ''),
    'ay': ('the same', '', ''), 'az': ('the same', '', ''), 'parameter': ('name of a PARAmeter', '', ''), 'value': ('a value of it', '', ''),
    'from': ('first value', '', ''), 'to': ('last value', '', ''), 'step': ('step', '', ''), 'dof': ('1, 2 or 3', '', ''),
    'time': ('time', 'time', ''), 'pair': ('name of a pair', '', ''), 'load': ('number of a load', '', ''), 'dt': ('size of the next step', 'time', ''),
    'point': ('number of a corner, 1 to 8', '', ''), 'STEP n': ('number of load steps', '', ''), 'LOOP n': ('most passes', '', ''),
    'DISPlacement n1': ('first node', '', ''), 'DISPlacement n2': ('last node', '', ''), 'DISPlacement n3': ('step', '', '1'),
    'EVERy n': ('distance of the load steps that are written', '', '1'), 'LAST n': ('states that are kept', '', '4'),
}
RELATED = {
    'CONTact': 'SURFace MATErial', 'PENAlty': 'AUGMent', 'AUGMent': 'PENAlty', 'FRICtion': 'DIREction SLIP DECAy CAP', 'DIREction': 'FRICtion SLIP',
    'SLIP': 'FRICtion DIREction', 'NTOS': 'GTOS SURFace', 'GTOS': 'NTOS SURFace', 'SMOOth': 'ADJUst SHRInk', 'ADJUst': 'SMOOth SHRInk',
    'SHRInk': 'ADJUst PROPortional', 'SURFace': 'SET CONTact', 'SET': 'SURFace', 'BOUNdary': 'DISPlacement EBOUndary CBOUndary',
    'DISPlacement': 'BOUNdary FPROportional PROPortional', 'FORCe': 'FPROportional TRACtion PRESsure', 'PROPortional': 'FPROportional',
    'FPROportional': 'PROPortional', 'RIGId': 'ROTAtion HOLD', 'ROTAtion': 'RIGId', 'HOLD': 'RIGId SPRIng', 'STEP': 'DT TIME', 'DT': 'STEP',
    'TIME': 'TANG LOOP', 'LOOP': 'NEXT TANG', 'TANG': 'FORM SOLVer', 'OUTPut': 'REACtion DISPlacement', 'STUDy': 'SENSitivity PARAmeter',
    'SENSitivity': 'STUDy PARAmeter', 'MESH': 'BLOCk COORdinates', 'BLOCk': 'MESH MATErial', 'MATErial': 'GLOBal RIGId', 'TOL': 'STEP',
    'TRACtion': 'PRESsure', 'PRESsure': 'TRACtion', 'GRAVity': 'MATErial', 'DECAy': 'FRICtion CAP', 'CAP': 'FRICtion DECAy'}
CHAPTERS = {'CONTact': '6-contact', 'OUTPut': '7-output-requests', 'MATErial': '4-materials', 'MESH': 'mesh', 'BLOCk': 'block', 'SET': 'set',
            'SURFace': 'surface', 'TRANsform': 'transform', 'TIE': 'tie', 'STUDy': 'studies', 'SENSitivity': 'derivatives-along-the-run'}
LOADS = ('BOUNdary DISPlacement FORCe FPROportional PROPortional EBOUndary EDISplacement EFORce EPROportional CBOUndary CDISplacement CFORce '
         'CPROportional TRACtion PRESsure RIGId HOLD ROTAtion SPRIng GRAVity').split()


def said(program, *words):
    """What the program says of a word."""
    return subprocess.run([program, '--help', *words], capture_output=True, text=True, check=True).stdout


def commands(program):
    """Mesh and solution commands in the order of the program."""
    parts = re.split(r'\n(?=Mesh commands|Solution commands|Words of FEAP)', said(program))
    return [(re.findall(r'(?m)^  (\w+)', part), kind) for kind in ('Mesh', 'Solution') for part in parts
            if part.startswith(kind)]


class Entry:
    """One part of what --help says: a command, or a word as a record of one."""

    def __init__(self, text):
        head, _, rest = text.partition('\n')
        found = re.match(r'(\w+)(?: as a record of (\w+).*)?:(.*)', head)
        self.word, self.owner, self.summary = found.group(1), found.group(2) or '', found.group(3).strip()
        self.syntax, self.records, self.notes = [], [], []
        lines = rest.split('\n')
        while lines and not lines[0].strip():
            lines.pop(0)
        while lines and (lines[0].startswith(' ') and lines[0].strip()):
            line = lines.pop(0)
            depth = len(line) - len(line.lstrip())
            if depth == 6:
                self.records.append(line.strip())
                if self.owner:
                    self.summary = line.strip()
            self.syntax.append(line)
        for line in lines:
            if 'Example:' in line:
                self.notes.append(line[:line.index('Example:')])
                break
            self.notes.append(line)

    def forms(self):
        """The ways to write it, without what the records of a command mean."""
        return [line[4 if self.owner else 2:] for line in self.syntax if len(line) - len(line.lstrip()) != 6]

    def words(self):
        """Words that begin its own records."""
        return list(dict.fromkeys(match.group(1) for line in self.syntax
                                  for match in [re.match(r'    ([A-Z]{2}\w*)', line)] if match)) if not self.owner else []

    def labels(self):
        """Names of what its forms take."""
        return list(dict.fromkeys(label for form in self.forms() for label in re.findall(
            r'(?<![\w|])([a-zA-Z]\w*)(?![\w|])', form) if label in PARAMETERS or f'{self.word} {label}' in PARAMETERS
            or form.split()[0] + ' ' + label in PARAMETERS))


def entries(program, word):
    """All that the program says of a word."""
    text = '\n' + said(program, word)
    return [Entry(part.strip('\n')) for part in re.split(r'\n(?=\w+(?: as a record of [^\n]*)?: ?[^\n]*\n\n)', text) if part.strip()
            and re.match(r'\w+( as a record of .*)?:', part.strip('\n'))]


def decks():
    """Example decks, shortest first: path and lines."""
    found = []
    for path in glob.glob(os.path.join(TOP, 'inputs', '**', '*.inp'), recursive=True) + \
            glob.glob(os.path.join(TOP, 'tests', 'regression', '*', '*.inp')):
        with open(path, encoding='ascii') as stream:
            found.append((len(found), os.path.relpath(path, TOP), stream.read().split('\n')))
    return sorted(((not path.startswith('inputs'), len(lines), path, lines) for _, path, lines in found))


def data_sets(lines):
    """Data sets of the mesh commands, and the solution commands as one: their lines."""
    sets, part = [], []
    for line in lines:
        batch = part and re.match(r'(?i)(batc|macr)', part[0])
        if batch and not re.match(r'(?i)end\b', line):
            part.append(line.rstrip())
        elif batch:
            sets.append(part + [line.rstrip()])
            part = []
        elif line.startswith(' ') and line.strip() and part:
            part.append(line.rstrip())
        else:
            sets.append(part)
            part = [line.rstrip()] if line.strip() and not line.startswith('!') else []
    return [part for part in sets if part]


def piece(word, owner, all_decks, batch):
    """The data set of the first deck that has the word, if it is not long: the deck's path and lines."""
    key, head = word[:4].lower(), (owner or word)[:4].lower()
    for _, _, path, lines in all_decks:
        for part in data_sets(lines):
            is_batch = part[0][:4].lower() in ('batc', 'macr')
            firsts = [re.split(r'[ ,]+', line.split('!')[0].strip() + ' ')[0].lower()[:4] for line in part]
            if batch != is_batch or len(part) > MOST_LINES or not batch and firsts[0] != head:
                continue
            if (key in firsts[1:]) if batch or owner else True:
                return path, part
    return '', []


def parameters(entry):
    """The table of its parameters."""
    lines = []
    for label in entry.labels():
        owner = entry.word
        for form in entry.forms():
            if label in form and f'{form.split()[0]} {label}' in PARAMETERS:
                owner = form.split()[0]
        meaning, unit, default = PARAMETERS.get(f'{owner} {label}') or PARAMETERS[label]
        optional = any(f'[{label}]' in form for form in entry.forms())
        lines.append(f'| `{label}` | {meaning} | {unit or "–"} | {default or ("may be left out" if optional else "must be given")} |')
    return ['| parameter | meaning | unit | default |', '|---|---|---|---|'] + lines + [''] if lines else []


def chapter(entry):
    """Where the guided chapters speak of it."""
    word = entry.owner or entry.word
    anchor = CHAPTERS.get(word) or ('5-supports-and-loads' if word in LOADS else '')
    return f'[manual](../manual.md#{anchor})' if anchor else '[manual](../manual.md)'


def page(word, found, all_decks, known):
    """The page of a word."""
    lines = [f'# {word}', '']
    for entry, kind in found:
        what = f'Record of [{entry.owner}]({entry.owner}.md)' if entry.owner else f'{kind} command'
        lines += [f'{what}: {entry.summary or "see there"}.', '', '```text'] + entry.forms() + ['```', '']
        lines += parameters(entry)
        words = [w for w in entry.words() if w in known and w != word]
        if words:
            lines += ['Its records: ' + ', '.join(f'[{w}]({w}.md)' for w in words) + '.', '']
        text = ' '.join(line.strip() for line in entry.notes if line.strip() and not line.startswith(' '))
        lists = ['- ' + line.strip() for line in entry.notes if line.startswith('  ')]
        text = re.sub(r'(?<=[.)]) (?=[A-Z]{2}\w*(, [A-Z]{2}\w*)*[:(])', '\n\n', text)
        lines += ([text, ''] if text else []) + (lists + [''] if lists else [])
        path, part = piece(word, entry.owner, all_decks, kind == 'Solution')
        if part:
            lines += [f'Of `{path}`, a complete deck:', '', '```'] + part + ['```', '']
    also = [w for w in RELATED.get(word, '').split() if w in known]
    lines += ['See also: ' + ', '.join([f'[{w}]({w}.md)' for w in also] + [chapter(found[0][0])]) + '.']
    return '\n'.join(lines) + '\n'


def made(program):
    """All pages: {path under doc: text}."""
    kinds, order = {}, []
    for names, kind in commands(program):
        for name in names:
            kinds.setdefault(name, []).append(kind)
            order.append(name)
    all_decks, found = decks(), {}
    for name in dict.fromkeys(order):
        mine = [e for e in entries(program, name) if e.word[:4].upper() == name[:4].upper()]
        for entry, kind in zip([e for e in mine if not e.owner], kinds[name]):
            found.setdefault(name, []).append((entry, kind))
            for word in entry.words():
                for other in entries(program, word):
                    if other.owner == name and other.word == word and not any(
                            e.owner == name for e, _ in found.get(word, ())):
                        found.setdefault(word, []).append((other, kind))
    pages = {f'keywords/{word}.md': page(word, mine, all_decks, found) for word, mine in found.items()}
    index = ['# Keywords, A to Z', '', 'Made from the keyword table of the program: `./mfec --help KEYWORD` says the same on the terminal. Four '
             'letters of a keyword count, those in capitals; upper and lower case are one. The guided chapters are in the [manual](manual.md).', '',
             '| keyword | is | what it does |', '|---|---|---|']
    for word in sorted(found, key=str.lower):
        for entry, kind in found[word]:
            where = f'record of {entry.owner}' if entry.owner else f'{kind.lower()} command'
            index.append(f'| [{word}](keywords/{word}.md) | {where} | {entry.summary} |')
    pages['keywords.md'] = '\n'.join(index) + '\n'
    return pages


def old_pages(program, fix=False):
    """Names of pages that are not what the program says; writes them with fix."""
    pages, wrong = made(program), []
    there = {os.path.relpath(p, os.path.join(TOP, 'doc')) for p in glob.glob(os.path.join(FOLDER, '*.md'))}
    os.makedirs(FOLDER, exist_ok=True)
    for name, text in pages.items():
        if is_old(os.path.join(TOP, 'doc', name), text, fix):
            wrong.append(name)
    for name in sorted(there - set(pages)):
        wrong.append(name)
        if fix:
            os.remove(os.path.join(TOP, 'doc', name))
    return wrong


def main():
    """Exit code 1 if a page is old."""
    given = sys.argv[1:]
    program = given[given.index('--program') + 1] if '--program' in given else os.path.join(TOP, 'mfec')
    wrong = old_pages(program, '--fix' in given)
    for name in wrong if '--fix' not in given else ():
        print(f'doc/{name} is not what the program says: doc/keywords.py --fix')
    return 1 if wrong and '--fix' not in given else 0


if __name__ == '__main__':
    sys.exit(main())
