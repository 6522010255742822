"""Package for Spack 1.0 or newer: put this folder into a repository as packages/mfec. There is no address yet to take the
sources from: `spack dev-build mfec@X.Y.Z` at their top."""
from spack_repo.builtin.build_systems.makefile import MakefilePackage

from spack.package import *


class Mfec(MakefilePackage):
    """Finite elements for the quasi-static frictional contact of elastic bodies with anisotropic
    (elliptical) Coulomb friction."""

    license("GPL-2.0-or-later")

    version("1.0.0", preferred=True)

    variant("native", default=False, description="for the processor that it is built on")

    depends_on("c", type="build")
    depends_on("fortran", type="build")
    depends_on("gmake", type="build")
    depends_on("openblas")
    depends_on("suite-sparse@5.12:")
    depends_on("hdf5@1.10:+fortran~mpi")

    conflicts("%gcc@:11", msg="gfortran 12 or later")

    @property
    def build_targets(self):
        hdf5 = self.spec["hdf5"].prefix
        folders = " ".join(f"-L{self.spec[n].prefix.lib} -Wl,-rpath,{self.spec[n].prefix.lib}"
                           for n in ("openblas", "suite-sparse", "hdf5"))
        found = ["mfec", f"FC={spack_fc}", f"HDF5_INCLUDE={hdf5.include}",
                 f"LIBS={folders} -lopenblas -lumfpack -lcholmod -lhdf5_fortran -lhdf5 -ldl"]
        return found + (["NATIVE=1"] if "+native" in self.spec else [])

    def install(self, spec, prefix):
        make("install", f"PREFIX={prefix}", *self.build_targets[1:])

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_version(self):
        Executable(self.prefix.bin.mfec)("--version")
