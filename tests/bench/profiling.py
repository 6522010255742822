"""Where the processor time of a run goes, by library and kind of work (perf, else valgrind)."""
import os
import re
import shutil
import subprocess
import tempfile

import jobs
import measure

# The first pattern that fits a symbol or its library counts.
KINDS = (
    ('dense kernels bound by arithmetic (gemm, trsm, ...)',
     r'openblas.*(gemm|trsm|syrk|trmm|symm|potr|getr|copy)'),
    ('dense kernels bound by memory (gemv, symv, axpy, ...)',
     r'openblas.*(gemv|symv|trsv|trmv|axpy|dot|scal|swap|ger|nrm)'),
    ('dense kernels without a name (OpenBLAS)', r'openblas'),
    ('ordering (METIS, AMD, COLAMD)', r'metis|libamd|libcolamd|libcamd|libccolamd'),
    ('UMFPACK, beside its kernels', r'umfpack|umf'),
    ('CHOLMOD, beside its kernels', r'cholmod'),
    ('mfec: condensed contact', r'mfec.*(condens|complian|reduced|schur|(?<!resi)dual)'),
    ('mfec: contact search and elements', r'mfec.*(contact|facet|host|elmt5|friction|fold|pair)'),
    ('mfec: assembly and bulk elements', r'mfec.*(assembl|elmt|scatter|csc|pattern|matrix)'),
    ('mfec: reading the mesh', r'mfec.*(read|scan|line|expression|item|mesh|text|number)'),
    ('mfec: the rest', r'mfec'),
    ('results (HDF5)', r'hdf5'),
    ('kernel', r'kernel|vmlinux|\[k\]'),
    ('C and Fortran run-time library', r'libc|libgfortran|libm|ld-'),
)


def kind_of(library, symbol):
    """What a sample stands for."""
    for name, pattern in KINDS:
        if re.search(pattern, f'{library} {symbol}', re.I):
            return name
    return 'other'


def shares(lines):
    """Sums of `percent library symbol` rows by kind, and the rows themselves."""
    kinds, rows = {}, {}
    for line in lines:
        found = re.match(r'\s*([\d.]+)%\s+(\S+)\s+(?:\[[.k]\]\s+)?(\S+)', line)
        if found:
            share, library, symbol = float(found.group(1)), found.group(2), found.group(3)
            if symbol.startswith('0x'):
                symbol = '(no name)'
            kinds[kind_of(library, symbol)] = kinds.get(kind_of(library, symbol), 0.0) + share
            rows[library, symbol] = rows.get((library, symbol), 0.0) + share
    kinds = dict(sorted(kinds.items(), key=lambda item: -item[1]))
    return kinds, sorted(((p, *names) for names, p in rows.items()), reverse=True)


def tool():
    """The profiler there is."""
    for name in ('perf', 'valgrind'):
        if shutil.which(name):
            return name
    return None


def profile(program, job, folder):
    """Kinds and rows of one run of mfec in a folder, None where there is no profiler."""
    scene = jobs.MAKERS[job.scene](job.size)
    if scene.contact:
        scene.contact.own_method = job.method
    jobs.write_own(scene, folder, job.limit)
    run = [os.path.abspath(program), 'run.inp', '--quiet', '--solver', job.mode]

    def call(*command):
        return subprocess.run(command, cwd=folder, env=measure.environment(), text=True,
                              capture_output=True, check=False)

    if tool() == 'perf':
        call('perf', 'record', '-F', '199', '-o', 'perf.data', *run)
        said = call('perf', 'report', '-i', 'perf.data', '--stdio', '--sort', 'dso,symbol').stdout
        return shares(said.split('\n'))
    if tool() == 'valgrind':
        call('valgrind', '--tool=callgrind', '--callgrind-out-file=out.callgrind', *run)
        said = call('callgrind_annotate', '--threshold=99', 'out.callgrind').stdout
        found = re.findall(r'\(\s*([\d.]+)%\)\s+\S*?:(\S+) \[(\S+)\]', said)
        return shares(f'{p}% {os.path.basename(library)} {symbol}' for p, symbol, library in found)
    return None


def kept(programs, job, store):
    """The profile of a job as {job, kinds, rows}, run only once; None without a profiler."""
    key = measure.digest('profile', programs.digests[programs.own], job)
    result = store.get(key)
    if result is None and tool():
        with tempfile.TemporaryDirectory() as folder:
            kinds, rows = profile(programs.own, job, folder)
        result = {'kinds': kinds, 'rows': rows[:10], 'tool': tool(),
                  'job': f'{job.scene} n={job.size:g}, {job.mode}'}
        store.put(key, result)
    return result
