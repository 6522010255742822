"""What a run has left behind, and the checks that every run must pass."""
import math
import os
import re
import statistics

CUT = re.compile(r'^step +\d+ cut: ', re.MULTILINE)
CONVERGED = re.compile(r'increment +\d+ converged:.* solves *(\d+)')


class Outcome:
    """Exit code, messages and tables of one run."""

    def __init__(self, folder, base, run):
        self.run = run
        self.texts = {}
        for ending in ('rea', 'con', 'log'):
            path = os.path.join(folder, f'{base}.{ending}')
            if os.path.exists(path):
                with open(path, encoding='utf-8') as stream:
                    self.texts[ending] = stream.read()
        self.rea = table(self.texts.get('rea', ''), 3)
        self.con = table(self.texts.get('con', ''), 3)
        log = self.texts.get('log', '')
        self.solves = [int(n) for n in CONVERGED.findall(log)]
        self.cuts = len(CUT.findall(log))

    def rows(self, which, name):
        """Rows of one set or pair in order of time: (time, [values])."""
        source = self.rea if which == 'rea' else self.con
        return [(time, values) for _, time, label, values in source if label == name]

    def last(self, which, name):
        """Values of the last row of a set or pair."""
        return self.rows(which, name)[-1][1]

    def median(self):
        """Median of the linear solves of an increment."""
        return statistics.median(self.solves) if self.solves else 0

    def worst(self):
        """Most linear solves of an increment."""
        return max(self.solves, default=0)


def table(text, _):
    """Rows (step, time, label, values) of a .rea or .con file."""
    rows = []
    for line in text.split('\n'):
        if line.startswith('#') or not line.strip():
            continue
        items = line.split()
        rows.append((int(items[0]), float(items[1]), items[2], [float(v) for v in items[3:]]))
    return rows


FACET = r'facet of nodes \d+, \d+, \d+'
POINT = re.compile(rf'pair \S+, slave (node \d+|{FACET}), {FACET}: (open|stick|slip)')
LEFT = re.compile(r'the body of element \d+[^\n]* has rotated by [\d.]+ degrees')


def message_helps(text):
    """An exit code 2 must name pair, slave node or facet, facet and status, node and dof, and a
    remedy; of a body that has left small strain the body, how far, and a remedy."""
    if 'ever smaller increments' in text and 'smaller steps (DT)' in text:
        return False
    if 'small strain can' in text or 'limit of small strain' in text:
        return bool(LEFT.search(text)) and 'BOUNdary' in text
    return bool(POINT.search(text)) and bool(re.search(r'node \d+, dof [123]', text)) and any(
        word in text for word in ('BOUNdary', 'restrain', '(DT)', 'PENAlty', 'ADJUst'))


def common_faults(outcome, scene):
    """What is wrong with a run, whatever the scene."""
    run = outcome.run
    crash = run.crash()
    if crash:
        return [crash]
    if run.code not in (0, 2):
        return [f'exit code {run.code}: ' + ' / '.join(run.err.split('\n')[:3])]
    faults = []
    for ending, text in outcome.texts.items():
        if re.search(r'\b(nan|inf(inity)?)\b|\*\*\*\*', text, re.IGNORECASE):
            faults.append(f'NaN, Infinity or stars in .{ending}')
    if run.code == 2 and not message_helps(run.err):
        faults.append('message does not name pair, node and facet: '
                      + ' / '.join(run.err.strip().split('\n')))
    if not faults:
        faults += friction_faults(outcome, scene)
        faults += balance_faults(outcome, scene)
    return faults


def friction_faults(outcome, scene):
    """Ft <= mu Fn, criterion <= round-off."""
    worst_ft = worst_criterion = 0.0
    # law, weights and frames of MORTar settle to 1e-9 of the forces, with rigid bodies to 1e-6
    settled = 1e-6 if scene.deck.form == 'MORTar' else 1e-9
    for _, _, pair, values in outcome.con:
        if pair not in scene.mus:
            continue
        mu1, mu2 = scene.mus[pair]
        normal, tangential, depth, criterion = values[3], values[4], values[11], values[13]
        bound = max(mu1, mu2)*normal
        slack = settled*(normal if scene.deck.form == 'MORTar' else bound)
        if tangential > bound + slack + 1e-300:
            worst_ft = max(worst_ft, (tangential - bound)/max(normal, 1e-300))
        if min(mu1, mu2) > 0.0:
            allowed = 1e-9*depth + 1e-14*scene.factor/min(mu1, mu2)
            if scene.deck.form == 'MORTar':  # a force there
                allowed = settled*normal + 1e-300
            worst_criterion = max(worst_criterion, criterion/allowed)
    faults = []
    if worst_ft > 0.0:
        faults.append(f'Ft exceeds mu Fn by {worst_ft:.1e} Fn')
    if worst_criterion > 1.0:
        faults.append(f'friction criterion {worst_criterion:.1e} times its round-off')
    return faults


def imbalance(outcome, scene):
    """Largest |supports + contact + loads| of a body over Fn, and where it is."""
    worst, where = 0.0, ''
    top = max((row[3][3] for row in outcome.con), default=0.0)
    by_time = {}
    for _, time, label, values in outcome.con:
        by_time.setdefault(time, {})[label] = values
    reactions = {}
    for _, time, label, values in outcome.rea:
        reactions.setdefault(time, {})[label] = values
    for name, sets, signs, load in scene.balance:
        for time, pairs in by_time.items():
            total = list(load(time))
            scale = 0.0
            for label in sets:
                total = [a + b for a, b in zip(total, reactions[time][label])]
            for pair, sign in signs.items():
                total = [a + sign*b for a, b in zip(total, pairs[pair][5:8])]
                scale += pairs[pair][3]
            ratio = math.dist(total, (0, 0, 0))/max(scale, 1e-3*top, scene.floor)
            if ratio > worst:
                worst, where = ratio, f'{name} at time {time:g}'
    return worst, where


def balance_faults(outcome, scene):
    """Contact forces balance reactions and loads to 1e-9 of Fn."""
    worst, where = imbalance(outcome, scene)
    if worst > scene.balance_wanted:
        return [f'contact and reactions differ by {worst:.1e} Fn ({where})']
    return []
