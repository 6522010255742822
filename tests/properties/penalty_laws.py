"""What the audit says of the penalty, against true errors: tests of tests/properties/run, which mixes
this class in."""
import os
import re

import decks

DECKS = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'decks')
# Of the same points with this factor the penalty takes less than a thousandth.
RIGHT = '1e4'
FACTOR = 2.0


class PenaltyLaws:
    """Tests of the audit's row; self.edited and self.true: from Suite."""

    SCENES = (('punched_pad', 'flat punch', ()),
              ('punched_pad', 'flat punch under a load', (30,)),
              ('punched_pad', 'flat punch on a single layer', (), ('CART 8 8 4 ', 'CART 8 8 1 ')),
              ('pressed_pad', 'ball', ()),
              ('pressed_pad', 'ball under a load', (30,)),
              ('pressed_pad', 'ball on rubber', (), ('nu = 0.3', 'nu = 0.49')))

    def penalised(self, name, load, changes, penalty):
        """Depth and force of the tool, the audit's row as a share, and its warnings on the terminal."""
        changes = list(changes) + [('AUTO 10', penalty)]
        if load:
            changes.append((r'MOVE 0 0 \S+ 1', f'MOVE 0 0 FREE 1\n  LOAD 0 0 -{load[0]} 0 0 0 1'))
        deck = self.edited(name, *changes, source=DECKS)
        done = decks.run(self.program, [deck, '--out', self.folder], self.folder, 120)
        if done.code != 0:
            raise RuntimeError(f'{name}, {penalty}: exit code {done.code}: {done.err[-300:]}')
        with open(os.path.join(self.folder, 'edited.rig'), encoding='ascii') as stream:
            last = stream.read().split('\n')[-2].split()
        with open(os.path.join(self.folder, 'edited.log'), encoding='utf-8') as stream:
            rows = re.findall(r'(?m)^  penalty +(?:ok|warning) +takes about (\S+) %', stream.read())
        told = re.findall(r'(?m)^warning: step \d, penalty: takes about .*$', done.out + done.err)
        return float(last[5]), float(last[11]), float(rows[-1])/100, told

    def test_penalty_row_is_near_the_true_error(self):
        """Force too small under a way, way too large under a force: within a factor of 2. A warning
        where it is more than 1 %, and its remedies make it less."""
        for name, words, load, *changes in self.SCENES:
            depth, force, share, _ = self.penalised(name, load, changes, f'AUTO {RIGHT}')
            self.true(f'{words}: {share} at {RIGHT} E/h', 0 < share < 1e-3)
            before = 1.0
            for factor in ('1', '10', '100'):
                found, pressed, share, told = self.penalised(name, load, changes, f'AUTO {factor}')
                error = 1 - depth/found if load else 1 - pressed/force
                self.true(f'{words}, {factor} E/h: row {share}, true {error:.4f}',
                          1/FACTOR < share/error < FACTOR)
                self.true(f'{words}, {factor} E/h: {share} and {told}', share == 0.01 or
                          len(told) == (share > 0.01))
                self.true(f'{words}, {factor} E/h: {before} before {share}', share < 0.7*before)
                before = share
                self.true(f'{words}: what to do: {told}', all(' PENAlty ' in line and 'MORTar' in line
                                                             for line in told))
            _, _, share, told = self.penalised(name, load, changes, 'AUTO 10\n    AUGMent')
            self.true(f'{words}, AUGMent: {share}, {told}', share < 0.01 and not told)
