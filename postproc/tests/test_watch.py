"""mfec-post watch follows a log that grows, and ends with its run."""
import fcntl
import os
import subprocess
import threading
import time

import mfec
import pytest
from mfec_post import cli

SOLVE = ('step     {0} time  {0}.00000E-01 iteration  1  Residual norm =  {1:.5E}  '
         'Energy convergence test =  5.40243E-03\n')
TABLE = '# a run\n#   step  time  set  R1  R2  R3\n'
ROW = ' {0} {0}.0E-1 top {0}.0 0.0 -2.0\n'
END = 'whole run                                        1.149\n'


def a_run(base, end, steps=3):
    """Writes log and table as the program does: the log is locked, lines may come in pieces."""
    with open(base + '.log', 'w', encoding='utf-8') as log, \
            open(base + '.rea', 'w', encoding='utf-8') as table:
        fcntl.flock(log, fcntl.LOCK_EX)
        log.write('mfec\n')
        table.write(TABLE)
        for step in range(1, steps + 1):
            line = SOLVE.format(step, 10.0 ** -step)
            for piece in (line[:30], line[30:]):
                log.write(piece)
                log.flush()
                time.sleep(0.05)
            table.write(ROW.format(step))
            table.flush()
        log.write(end)


def watched(folder, end, *words):
    """Exit code of a watch that begins with the run."""
    base = os.path.join(folder, 'x')
    thread = threading.Thread(target=a_run, args=(base, end))
    thread.start()
    while not os.path.exists(base + '.rea'):
        time.sleep(0.01)
    code = cli.main(['watch', base + '.log', '--every', '0.02', *words])
    thread.join()
    return code


@pytest.mark.parametrize('end, code, said', [(END, 0, 'done'), ('', 1, 'killed: its log has no end'), (
    'stopped by a signal at time 0.2\n' + END, 1, 'stopped by a signal at time 0.2')])
def test_it_ends_as_the_run_does(tmp_path, capsys, end, code, said):
    """Done, killed, stopped; the last lines have been read."""
    assert watched(tmp_path, end, '--text') == code
    lines = capsys.readouterr().out.split('\n')
    assert lines[-2].endswith(f'x.log: {said}')
    assert 'step 3, time 0.3, 3 solves' in lines[-6] and '0.001' in lines[-5]
    assert lines[-4].split()[:3] == ['top', 'R1', '3'] and lines[-3].split()[:3] == ['top', 'R3', '-2']


def test_a_picture(tmp_path):
    """It is there at the end, and nothing else is left."""
    assert watched(tmp_path, END, '--out', str(tmp_path / 'x.png')) == 0
    assert (tmp_path / 'x.png').read_bytes()[:4] == b'\x89PNG'
    assert sorted(os.listdir(tmp_path)) == ['x.log', 'x.png', 'x.rea']


def test_a_run_of_the_program(tmp_path, capsys):
    """As many solves as its log counts."""
    deck = str(mfec.example('sliding_cube'))
    with subprocess.Popen([mfec.find_program(), deck, '--quiet', '--out', str(tmp_path)]) as run:
        while not (tmp_path / 'sliding_cube.log').exists():
            time.sleep(0.01)
        assert cli.main(['watch', str(tmp_path / 'sliding_cube.log'), '--text', '--every', '0.05']) == 0
        assert run.wait() == 0
    text = (tmp_path / 'sliding_cube.log').read_text(encoding='utf-8')
    said = capsys.readouterr().out
    assert f'{text.count("Residual norm")} solves' in said and 'ground R3' in said


def test_no_such_log(tmp_path, capsys):
    """A message, exit code 2."""
    assert cli.main(['watch', str(tmp_path / 'none.log'), '--text']) == 2
    assert 'none.log' in capsys.readouterr().err
