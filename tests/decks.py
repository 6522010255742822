"""What the scripts that run decks have in common (standard library only)."""
import argparse
import os
import re
import subprocess
import sys
import tempfile

TRACES = ('Fortran runtime error', 'Backtrace for this error', 'Program received signal',
          'Error termination', 'Floating-point exception', 'Segmentation fault', 'free():',
          'malloc(', 'corrupted', 'terminate called', 'fault of ours', 'AddressSanitizer',
          ': runtime error: ')
# The sanitisers: their findings end the run with a code of its own; libraries keep what they
# allocate, so leaks say nothing; an allocation that is too large fails as it does without them.
SANITISERS = {
    'ASAN_OPTIONS': 'exitcode=99:detect_leaks=0:allocator_may_return_null=1:'
                    'max_allocation_size_mb=2048:soft_rss_limit_mb=3000:handle_segv=2:'
                    'detect_stack_use_after_return=0',
    'UBSAN_OPTIONS': 'print_stacktrace=1:exitcode=99'}
# Before gfortran 12 gives an array its first value it computes, to no end, the extent it had from what
# stands on the stack, which may overflow. Our own integers, but for a few, are of another kind.
NO_FINDING = re.compile(r"[^\n]*: runtime error: signed integer overflow: [^\n]*'integer\(kind=8\)'\n"
                        r'(?: +#\d[^\n]*\n)*\n?')
HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(HERE)


class Run:
    """One finished run of the program."""

    def __init__(self, code, out, err, timed_out):
        self.code, self.out, self.err, self.timed_out = code, out, err, timed_out

    def crash(self):
        """What is wrong with the way it ended, '' if it ended properly."""
        if self.timed_out:
            return 'did not end in time'
        for text in TRACES:
            if text in self.err or text in self.out:
                return f'crashed: {text}'
        if self.code < 0:
            return f'ended by signal {-self.code}'
        return ''


def run(program, arguments, folder, seconds, limit=None):
    """Runs the program in a folder; limit is called in the child before it starts."""
    environment = dict(os.environ, OPENBLAS_NUM_THREADS='1', OMP_NUM_THREADS='1', LC_ALL='C',
                       **SANITISERS)
    try:
        done = subprocess.run([os.path.abspath(program)] + arguments, cwd=folder, timeout=seconds,
                              env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, preexec_fn=limit, check=False)
        code, out, err, late = done.returncode, done.stdout, done.stderr, False
    except subprocess.TimeoutExpired as late_run:
        code, out, err, late = -9, late_run.stdout or b'', late_run.stderr or b'', True
    err = NO_FINDING.sub('', err.decode('utf-8', 'replace'))
    return Run(code, out.decode('utf-8', 'replace'), err, late)


def is_sanitised(program):
    """Whether a program was built by `make sanitize`: its address space cannot be limited."""
    with open(program, 'rb') as stream:
        return b'__asan_init' in stream.read()


def fresh_folder():
    """A temporary folder that removes itself."""
    return tempfile.TemporaryDirectory(prefix='mfec-', ignore_cleanup_errors=True)


def processors():
    """How many processors this process may use, as nproc counts them: a container is seldom given all."""
    return len(os.sched_getaffinity(0))


def replace_part(path, name, text):
    """Replaces what stands between `<!-- name -->` and `<!-- end name -->` in a file; writes the
    text alone where there is no such file or place."""
    begin, end = f'<!-- {name} -->\n', f'<!-- end {name} -->'
    if os.path.exists(path):
        with open(path, encoding='utf-8') as stream:
            old = stream.read()
        if begin in old and end in old:
            text = old[:old.index(begin)] + begin + text + old[old.index(end):]
    with open(path, 'w', encoding='utf-8') as stream:
        stream.write(text)


def parser(text):
    """The options all runners share."""
    options = argparse.ArgumentParser(description=text,
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--program', default=os.path.join(TOP, 'mfec'), help='what to run')
    options.add_argument('-v', '--verbose', action='store_true', help='name what passes, too')
    return options


class Report:
    """Counts, prints failures at once and the closing line at the end."""

    def __init__(self, verbose=False):
        self.passed = self.failed = 0
        self.verbose = verbose

    def add(self, name, faults):
        """One test with the list of what is wrong."""
        if faults:
            self.failed += 1
            print(f'FAILED {name}')
            for fault in faults:
                print('   ' + fault.replace('\n', '\n   '))
        else:
            self.passed += 1
            if self.verbose:
                print(f'passed {name}')
        sys.stdout.flush()

    def close(self):
        """Prints the closing line; the exit code."""
        print(f'{self.passed} passed, {self.failed} failed')
        return 1 if self.failed or not self.passed else 0
