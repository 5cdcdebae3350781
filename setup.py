"""The compiled part of the build; everything else is in pyproject.toml.

The kernels are Python files in Cython's pure Python mode, compiled in place of themselves.
``WEFT_CHECKS=1`` builds them with bounds and overflow checks, to run the test suite against.
"""

import os
import platform
import shutil
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
AVX2 = "/arch:AVX2" if MSVC else "-mavx2"


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

    def copy_extensions_to_source(self):
        for extension in self.extensions:  # an editable install has no folder for AVX2 yet
            inplace = self._get_inplace_equivalent(self.get_finalized_command("build_py"), extension)
            os.makedirs(os.path.dirname(inplace[0]), exist_ok=True)
        super().copy_extensions_to_source()


def kernels():
    """Every kernel for any processor, and on x86-64 once more for those with AVX2 (weft/_cpu.py)."""
    plain = cythonize(
        [
            setuptools.Extension(
                name,
                [f"src/{name.replace('.', '/')}.py"],
                extra_compile_args=FLAGS + os.environ.get("WEFT_CFLAGS", "").split(),
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
            "freethreading_compatible": True,
        },
    )
    if CHECKS or platform.machine() not in ("x86_64", "AMD64"):
        return plain
    fast = []
    for extension in plain:
        source = extension.sources[0]
        copy = source.replace("build/cython", "build/avx2", 1)  # or the object files would collide
        os.makedirs(os.path.dirname(copy), exist_ok=True)
        shutil.copy(source, copy)
        fast.append(
            setuptools.Extension(
                extension.name.replace("weft.", "weft._avx2.", 1),
                [copy],
                extra_compile_args=[*extension.extra_compile_args, AVX2],
            )
        )
    return plain + fast


setuptools.setup(cmdclass={"build_ext": BuildKernels}, ext_modules=kernels())
