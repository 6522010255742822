"""The verification decks, each run with two solvers."""
import importlib.machinery
import importlib.util
import os

import decks
import verifying
from comparing import Finished, compare

TABLE = os.path.join(os.path.dirname(os.path.abspath(verifying.__file__)), 'run')


class Twice(verifying.Bench):
    """Runs each deck of a study with UMFPACK and with REDUced; the study sees the second."""

    def __init__(self, program, folder):
        super().__init__(program, folder)
        self.pairs = []

    def launch(self, arguments, code):
        """Two runs and how they differ; the tables of the second."""
        ends = []
        for solver in ('UMFPack', 'REDUced'):
            tables = None
            try:
                tables = super().launch(arguments + ['--solver', solver], code)
            finally:
                ends.append(self.finished(arguments[0], tables, code))
        self.pairs.append((self.case, ends, compare(*ends)))
        return tables

    def finished(self, deck, tables, code):
        """The run that has just ended."""
        out = os.path.join(self.folder, f'run{self.runs}')
        run = decks.Run(code if tables else 2, '', '', False)
        return Finished(os.path.join(out, os.path.basename(deck)[:-4]), run)


def verification():
    """The studies of tests/verification/run, by name."""
    loader = importlib.machinery.SourceFileLoader('verification_run', TABLE)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module.all_studies()


def studies_twice(given, quick):
    """(name, the two runs, how they differ) for each deck of the studies that are asked for."""
    studies = verification()
    names = quick
    if given.full:
        names = studies
    if given.names:
        words = [word[len('verify '):] for word in given.names if word.startswith('verify ')]
        names = [name for name in studies if name in words or 'verify' in given.names]
    elif given.count:
        names = ()
    for name in names:
        with decks.fresh_folder() as folder:
            bench = Twice(given.program, folder)
            studies[name](bench)
            for number, (_, ends, difference) in enumerate(bench.pairs, 1):
                yield f'{name} {number}', ends, difference
