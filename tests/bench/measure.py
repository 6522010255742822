"""Runs one program in one thread and says what it took; results are kept, so a run can go on."""
import hashlib
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

ENOUGH = 3.0   # seconds of processor time after which a run is not repeated
REPEATS = 3
HERE = os.path.dirname(os.path.abspath(__file__))


def environment():
    """One thread each, and the BLAS chooses its own kernels."""
    result = {k: v for k, v in os.environ.items() if k != 'OPENBLAS_CORETYPE'}
    return dict(result, OPENBLAS_NUM_THREADS='1', OMP_NUM_THREADS='1', LC_ALL='C')


def spend(command, folder, seconds):
    """Runs a command in a folder; it is killed when it has used that much processor time."""
    said = os.path.join(folder, 'standard_output')
    own = f'{HERE}/spend.py'
    done = subprocess.run(
        ['sh', '-c', 'exec "$@" 3>&1 >standard_output 2>&1', 'sh', sys.executable, '-S', '-E', own,
         str(int(seconds)), *command], cwd=folder, env=environment(), stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, check=False, timeout=20*seconds + 60)
    spent = json.loads(done.stdout)
    spent['late'] = spent['cpu'] >= seconds
    if spent['code'] == 127:
        raise OSError(f'cannot run {command[0]}: see {said}')
    return spent


def digest(*parts):
    """A short name for everything a result depends on."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(part if isinstance(part, bytes) else str(part).encode())
        whole.update(b'\0')
    return whole.hexdigest()[:20]


def file_digest(path):
    """The same for a program."""
    with open(path, 'rb') as stream:
        return digest(stream.read())


class Store:
    """Results by digest, one JSON file each."""

    def __init__(self, folder, fresh=False):
        self.folder, self.fresh = folder, fresh
        os.makedirs(folder, exist_ok=True)

    def get(self, key):
        """The result kept under a key, None if there is none."""
        path = os.path.join(self.folder, key + '.json')
        if self.fresh or not os.path.exists(path):
            return None
        with open(path, encoding='utf-8') as stream:
            return json.load(stream)

    def put(self, key, result):
        """Keeps a result."""
        path = os.path.join(self.folder, key + '.json')
        with open(path + '.new', 'w', encoding='utf-8') as stream:
            json.dump(result, stream, indent=1)
        os.replace(path + '.new', path)


def repeat(command, files, seconds, read, repeats=REPEATS, outputs=()):
    """Runs a command up to `repeats` times in a fresh folder, short ones more often than long ones;
    `files` writes what it reads, `read` makes values of what the first run wrote."""
    folder = tempfile.mkdtemp(prefix='mfec-bench-')
    try:
        files(folder)
        runs, values = [], None
        while len(runs) < repeats and (not runs or sum(r['cpu'] for r in runs) < ENOUGH):
            for name in outputs:
                if os.path.exists(os.path.join(folder, name)):
                    os.remove(os.path.join(folder, name))
            runs.append(spend(command, folder, seconds))
            if values is None:
                values = {} if runs[0]['late'] else read(folder, runs[0])
            if runs[0]['code']:
                break
    finally:
        shutil.rmtree(folder)
    values.update(code=runs[0]['code'], late=runs[0]['late'], runs=len(runs),
                  cpu=statistics.median(r['cpu'] for r in runs),
                  wall=statistics.median(r['wall'] for r in runs),
                  memory=statistics.median(r['memory'] for r in runs),
                  spread=[min(r['cpu'] for r in runs), max(r['cpu'] for r in runs)],
                  date=time.strftime('%Y-%m-%d'), load=os.getloadavg()[0])
    return values


def machine():
    """Processor, cores, memory, system."""
    model = platform.processor()
    with open('/proc/cpuinfo', encoding='utf-8') as stream:
        for line in stream:
            if line.startswith('model name'):
                model = line.split(':', 1)[1].strip()
                break
    memory = os.sysconf('SC_PHYS_PAGES')*os.sysconf('SC_PAGE_SIZE')/2**30
    return {'processor': model, 'cores': os.cpu_count(), 'memory': round(memory, 1),
            'system': platform.platform()}
