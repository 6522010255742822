"""A wheel that holds a program of this machine's kind, for any Python 3."""
from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel


class WithProgram(Distribution):
    """Goes to where what depends on the machine goes."""

    def has_ext_modules(self):
        return True


class ProgramWheel(bdist_wheel):
    """Nothing in it depends on the interpreter."""

    def get_tag(self):
        return 'py3', 'none', super().get_tag()[2]


setup(distclass=WithProgram, cmdclass={'bdist_wheel': ProgramWheel})
