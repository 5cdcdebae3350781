"""The compiled part of the build; everything else is in pyproject.toml.

The kernels are Python files in Cython's pure Python mode. With ``WEFTEX_CHECKS=1`` they are built
to run the tests against instead of for speed: Cython checks the bounds of arrays, and the compiler
(GCC or Clang) ends the process at an integer overflow or beyond a fixed array. With
``WEFTEX_SANITIZE=address,undefined`` they say where they use memory that is not theirs, see
CONTRIBUTING.md. With ``WEFTEX_ABI3=1`` one build serves Python 3.11 and later, but no free-threaded
one, as wheels do.
"""

import os
import platform
import shutil
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

import setuptools
from setuptools.command.build_ext import build_ext

#: Every kernel is a file of this pattern, beside what it serves.
KERNELS = sorted(
    ".".join(file.with_suffix("").parts[1:]) for file in Path("src").rglob("*kernels.py")
)
#: What every kernel needs for its arrays, compiled once and not in each of them.
SHARED = "weftex._memoryviews"
CHECKS = os.environ.get("WEFTEX_CHECKS") == "1"
SANITIZE = os.environ.get("WEFTEX_SANITIZE", "")
# Free-threaded Python has no stable interface before 3.15.
ABI3 = os.environ.get("WEFTEX_ABI3") == "1" and not sysconfig.get_config_var("Py_GIL_DISABLED")
# Apart, or one would take the other's objects.
KIND = "sanitize" if SANITIZE else "checks" if CHECKS else "abi3" if ABI3 else "plain"
BASE = f"build/{KIND}"
SHARED_C = Path(BASE, "c", "_memoryviews.c")
MSVC = sys.platform == "win32"
# No contraction into fused multiply-adds: floating point must give the same bytes everywhere.
FLAGS = ["-O3", "-g0", "-ffp-contract=off", "-fno-math-errno", "-Wno-unused-function"]
AVX2 = ["-mavx2"]
if MSVC:
    FLAGS, AVX2 = ["/O2", "/fp:precise"], ["/arch:AVX2"]
elif sys.platform == "darwin":
    AVX2 = ["-Xarch_x86_64", "-mavx2"]  # also for a Python of both architectures
if CHECKS:
    FLAGS += ["-fno-wrapv", "-fsanitize-undefined-trap-on-error"]
    FLAGS += ["-fsanitize=signed-integer-overflow,shift,integer-divide-by-zero,bounds"]
if SANITIZE:
    FLAGS += [f"-fsanitize={SANITIZE}", "-fno-omit-frame-pointer", "-fno-wrapv", "-g1", "-O1"]
    FLAGS += ["-fno-sanitize-recover=all"]  # or pytest would swallow what is said, and pass
FAST = not (CHECKS or SANITIZE) and platform.machine() in ("x86_64", "AMD64")
FAST &= not sysconfig.get_platform().startswith("emscripten")  # which is built elsewhere
LIMITED = {"py_limited_api": True, "define_macros": [("Py_LIMITED_API", "0x030B0000")]}

NO_COMPILER = """

weftex needs a C compiler, and this one could not build a module for Python:

  {error}

Install a compiler and run the same command again:

  Debian, Ubuntu   apt-get install gcc libc6-dev python3-dev
  Fedora, RHEL     dnf install gcc python3-devel
  Arch             pacman -S gcc
  macOS            xcode-select --install
  Windows          winget install Microsoft.VisualStudio.2022.BuildTools, with its C++ workload
"""


class BuildKernels(build_ext):
    """Turns the kernels into C and compiles them, all processors at work."""

    def finalize_options(self):
        super().finalize_options()
        self.parallel = self.parallel or os.cpu_count()

    def build_extensions(self):
        self.try_compiler()
        self.write_c()
        super().build_extensions()

    def try_compiler(self):
        """Compile and link nothing, so that a missing compiler is not met by a page of output."""
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder, "nothing.c")
            source.write_text("#include <Python.h>\nint PyInit_nothing(void) { return 0; }\n")
            try:
                objects = self.compiler.compile([str(source)], output_dir=folder)
                self.compiler.link_shared_object(objects, str(Path(folder, "nothing.so")))
            except Exception as error:  # each kind of compiler has its own
                raise SystemExit(NO_COMPILER.format(error=error)) from None

    def write_c(self):
        from Cython import __version__
        from Cython.Build import cythonize

        # pip installs Cython anew each time, and by its dates all kernels would be out of date.
        stamp, start = Path(BASE, "c", f"{__version__}.stamp"), time.time()
        sources = [*Path("src").rglob("*kernels.py"), *Path("src").rglob("*.pxd"), Path("setup.py")]
        written = all(Path(BASE, "c", python_file(k)).with_suffix(".c").exists() for k in KERNELS)
        if not written or not all(is_newer(stamp, file) for file in sources):
            print(f"weftex: writing {len(KERNELS)} kernels as C", flush=True)
            write_shared_c()
            self.write_kernels(cythonize)
            stamp.touch()
            os.utime(stamp, (start, start))
        self.place_c()

    def write_kernels(self, cythonize):
        cythonize(
            [setuptools.Extension(name, [python_file(name)]) for name in KERNELS],
            build_dir=f"{BASE}/c",
            nthreads=os.cpu_count() or 1,
            shared_utility_qualified_name=SHARED,
            compiler_directives={
                "language_level": 3,
                "boundscheck": CHECKS,
                "initializedcheck": CHECKS,
                "wraparound": False,
                "cdivision": True,
                "freethreading_compatible": True,
            },
        )

    def place_c(self):
        """Name the C files as the sources of the extensions."""
        kinds = "with checks" if CHECKS else "for any processor, and for AVX2" if FAST else "once"
        print(
            f"weftex: compiling what is new {kinds}, {self.parallel} at a time; "
            "all of it takes three minutes of processor time",
            flush=True,
        )
        for extension in self.extensions:
            if extension.name == SHARED:
                extension.sources = [str(SHARED_C)]
                continue
            source = Path(BASE, "c", extension.sources[0]).with_suffix(".c")
            if extension.name.startswith("weftex._avx2."):  # a copy, or their objects would collide
                copy = Path(BASE, "avx2", extension.sources[0]).with_suffix(".c")
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, copy)
                source = copy
            extension.sources = [str(source)]

    def copy_extensions_to_source(self):
        for extension in self.extensions:  # an editable install has no folder for AVX2 yet
            inplace = self._get_inplace_equivalent(
                self.get_finalized_command("build_py"), extension
            )
            os.makedirs(os.path.dirname(inplace[0]), exist_ok=True)
        super().copy_extensions_to_source()


def is_newer(file, other):
    """Whether a file is there and newer than another."""
    return file.exists() and file.stat().st_mtime > other.stat().st_mtime


def write_shared_c():
    """Write what Cython would put into every kernel, unless the one there is of this Cython."""
    import Cython
    from Cython.Build.SharedModule import generate_shared_module
    from Cython.Compiler.Main import CompilationOptions

    if is_newer(SHARED_C, Path(Cython.__file__)):
        return
    SHARED_C.parent.mkdir(parents=True, exist_ok=True)
    generate_shared_module(CompilationOptions(shared_c_file_path=str(SHARED_C), language_level=3))


def python_file(name):
    """The source of a kernel."""
    return f"src/{name.replace('.', '/')}.py"


def extension(name, kernel, flags):
    """A module to compile from a kernel; its declarations travel with it in the source archive."""
    source = Path(python_file(kernel))
    declarations = [str(file) for file in [source.with_suffix(".pxd")] if file.exists()]
    return module(name, [str(source)], depends=declarations, extra_compile_args=flags)


def module(name, sources, **options):
    """What setuptools is to compile."""
    options["extra_link_args"] = [f"-fsanitize={SANITIZE}"] if SANITIZE else []
    return setuptools.Extension(name, sources, **options, **(LIMITED if ABI3 else {}))


if __name__ == "__main__":  # processes that Cython starts import this file
    modules = [module(SHARED, [], extra_compile_args=FLAGS)]
    modules += [extension(name, name, FLAGS) for name in KERNELS]
    if FAST:  # and once more for processors with AVX2, see weftex/dispatch.py
        modules += [
            extension(name.replace("weftex.", "weftex._avx2.", 1), name, FLAGS + AVX2)
            for name in KERNELS
        ]
    setuptools.setup(
        cmdclass={"build_ext": BuildKernels},
        ext_modules=modules,
        options={
            "build": {"build_base": BASE},
            "bdist_wheel": {"py_limited_api": "cp311" if ABI3 else None},
        },
    )
