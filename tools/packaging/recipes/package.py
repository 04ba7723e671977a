# Spack's recipe: packages/vdblic/package.py of a repository of recipes.
#
# What was run: Python compiles this file. Nothing was built with Spack. Names of packages and variants are to be checked
# against Spack's own before the recipe is handed in; the address and the checksum follow with the first published archive.
from spack.package import *


class Vdblic(CMakePackage):
    """Flow textures (AUFLIC, UFLIC, streaks) of time-varying velocity volumes in OpenVDB's files, ray cast into pictures."""

    homepage = "https://github.com/OWNER/vdblic"
    git = "https://github.com/OWNER/vdblic.git"

    license("Apache-2.0")

    version("main", branch="main")

    variant("mpi", default=True, description="Build the tools that run under mpirun")
    variant("python", default=True, description="Build the module vdblic, vdblic_import and vdblic_export")
    variant("shared", default=False, description="Build the library as shared libraries")

    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("cli11", type="build")
    depends_on("openvdb@10:")
    depends_on("c-blosc")
    depends_on("boost+iostreams+math")
    depends_on("intel-oneapi-tbb")
    depends_on("openexr@3:")
    depends_on("xxhash")
    depends_on("libpng")
    depends_on("cairo")
    depends_on("fontconfig")
    depends_on("assimp")
    depends_on("embree@3.13:3")
    depends_on("glm")
    depends_on("fmt@9:")
    depends_on("nlohmann-json")
    depends_on("mpi", when="+mpi")
    depends_on("python@3.10:", when="+python")
    depends_on("py-pybind11", when="+python", type="build")
    depends_on("py-numpy", when="+python", type=("build", "run"))

    conflicts("%gcc@:11", msg="C++20 as GCC 12 has it")

    def cmake_args(self):
        return [
            self.define("VDBLIC_BUILD_TESTS", False),
            self.define("VDBLIC_BUILD_BENCHMARKS", False),
            self.define_from_variant("VDBLIC_MPI", "mpi"),
            self.define_from_variant("BUILD_SHARED_LIBS", "shared"),
            self.define("CMAKE_DISABLE_FIND_PACKAGE_pybind11", "+python" not in self.spec),
        ]
