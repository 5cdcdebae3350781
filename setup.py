"""The compiled part of the build; everything else is in pyproject.toml.

The kernels are Python files in Cython's pure Python mode, compiled in place of themselves.
``WEFT_CHECKS=1`` builds them with bounds and overflow checks, to run the test suite against.
"""

import os
import sys

import setuptools
from Cython.Build import cythonize
from setuptools.command.build_ext import build_ext

KERNELS = [
    "weft._compositing",
    "weft.search._kernels",
    "weft.seams._kernels",
    "weft.methods._patch_kernels",
]
CHECKS = os.environ.get("WEFT_CHECKS") == "1"
MSVC = sys.platform == "win32"
# No contraction into fused multiply-adds: floating point must give the same bytes on every machine.
FLAGS = ["/O2"] if MSVC else ["-O3", "-ffp-contract=off", "-fno-math-errno", "-Wno-unused-function"]


class BuildKernels(build_ext):
    """build_ext whose failure says what to install."""

    def build_extensions(self):
        try:
            super().build_extensions()
        except Exception as error:
            compiler = getattr(self.compiler, "compiler", None) or ["a C compiler"]
            raise SystemExit(
                f"\nweft could not compile its kernels with '{compiler[0]}': {error}\n"
                "weft needs a C compiler. Install one and run the same command again:\n"
                "  Debian, Ubuntu   apt-get install gcc libc6-dev python3-dev\n"
                "  Fedora           dnf install gcc python3-devel\n"
                "  macOS            xcode-select --install\n"
                "  Windows          the package 'Build Tools for Visual Studio' (C++ workload)\n"
            ) from error


setuptools.setup(
    cmdclass={"build_ext": BuildKernels},
    ext_modules=cythonize(
        [
            setuptools.Extension(
                name,
                [f"src/{name.replace('.', '/')}.py"],
                extra_compile_args=FLAGS + os.environ.get("WEFT_CFLAGS", "").split(),
                define_macros=[("CYTHON_WITHOUT_ASSERTIONS", "0" if CHECKS else "1")],
            )
            for name in KERNELS
        ],
        build_dir="build/cython",
        nthreads=os.cpu_count() or 1,
        compiler_directives={
            "language_level": 3,
            "boundscheck": CHECKS,
            "wraparound": False,
            "cdivision": True,
            "initializedcheck": CHECKS,
            "overflowcheck": False,
            "freethreading_compatible": True,
        },
    ),
)
