"""What the machine can do in one thread, and how fast mfec starts."""
import os
import statistics
import subprocess
import sys

import measure

CODE = '''
import time
import numpy as np
n = 1500
a, b = np.random.rand(n, n), np.random.rand(n, n)
best = 1e9
for _ in range(4):
    begin = time.process_time()
    a @ b
    best = min(best, time.process_time() - begin)
x = np.ones(16_000_000)
y = np.empty_like(x)
copy = 1e9
for _ in range(4):
    begin = time.process_time()
    np.copyto(y, x)
    copy = min(copy, time.process_time() - begin)
print(2e-9*n**3/best, 2*8e-9*x.size/copy)
'''


def machine_limits():
    """GFlop/s of dgemm and GB/s of a copy (read and written), in one thread."""
    done = subprocess.run([sys.executable, '-c', CODE], env=measure.environment(), check=True,
                          capture_output=True, text=True)
    gemm, copy = map(float, done.stdout.split())
    return {'dgemm': gemm, 'copy': copy}


def start_up(program, top):
    """A deck of ten elements: CPU time (median) and wall time (least) of 15 runs."""
    deck = os.path.join(top, 'tests', 'properties', 'ten_elements.inp')
    with open(deck, encoding='utf-8') as stream:
        text = stream.read()

    def files(folder):
        with open(os.path.join(folder, 'run.inp'), 'w', encoding='utf-8') as stream:
            stream.write(text)

    command = [os.path.abspath(program), 'run.inp', '--quiet']
    runs = [measure.repeat(command, files, 20, lambda folder, run: {}, repeats=1)
            for _ in range(15)]
    return {'load': os.getloadavg()[0], 'cores': os.cpu_count(),
            'code': max(r['code'] for r in runs), 'cpu': statistics.median(r['cpu'] for r in runs),
            'wall': min(r['wall'] for r in runs)}
