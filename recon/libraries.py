"""Loaders of libraries that are heavy, optional or need help from the system."""

import ctypes
import functools
import importlib
import importlib.util
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any

from recon.errors import MissingLibraryError

APT_LINE = "apt-get install -y --no-install-recommends libegl1 libgl1 libidn2-0 libusb-1.0-0"

# The first VTK render without these libraries kills the process, so it happens in a child.
_RENDER_PROBE = """
from recon.libraries import load_pyvista
pyvista = load_pyvista()
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.add_mesh(pyvista.Cube())
assert plotter.screenshot(return_img=True).any()
"""


@functools.cache
def load_open3d() -> ModuleType:
    """Open3D, after the libusb that its wheel needs but does not include."""
    import libusb_package

    library = libusb_package.get_library_path()
    if library is not None:
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    try:
        with _undisturbed():
            if "open3d" not in sys.modules:
                sys.modules[_LATE] = _late_plots()
            return importlib.import_module("open3d")
    except (ImportError, OSError) as error:
        # Its compiled part reports Ctrl-C as a failed import.
        if KeyboardInterrupt.__name__ in str(error):
            raise KeyboardInterrupt from error
        raise MissingLibraryError(f"Open3D does not load ({error}); run: {APT_LINE}") from error


_one_at_a_time = threading.Lock()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Keep other threads from running: Open3D iterates over `sys.modules` during its import, and
    fails if another thread imports something meanwhile.
    """
    with _one_at_a_time:
        interval = sys.getswitchinterval()
        sys.setswitchinterval(60.0)
        try:
            yield
        finally:
            sys.setswitchinterval(interval)


def load_late(name: str) -> None:
    """Load a module only when something in it is used, however it is imported."""
    spec = importlib.util.find_spec(name)
    if name in sys.modules or spec is None or spec.loader is None:
        return
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    package, _, own = name.rpartition(".")
    setattr(sys.modules[package], own, module)


def load_unused_late() -> None:
    """Spare SciPy the parts of NumPy that it loads without need, a twentieth of all imports."""
    for name in ("numpy.f2py", "numpy.testing"):
        load_late(name)


_LATE = "open3d.visualization.draw_plotly"
"""The part of Open3D that plots in notebooks; its web framework takes 40 % of the import."""


def _late_plots() -> ModuleType:
    """A module in its place whose functions load it when called."""
    module = ModuleType(_LATE)

    def late(name: str) -> Callable[..., object]:
        def call(*given: Any, **named: Any) -> object:
            if sys.modules.get(_LATE) is module:
                del sys.modules[_LATE]
            return getattr(importlib.import_module(_LATE), name)(*given, **named)

        return call

    for name in ("get_plotly_fig", "draw_plotly", "draw_plotly_server"):
        setattr(module, name, late(name))
    return module


@functools.cache
def load_pyvista() -> ModuleType:
    """PyVista, set to render off-screen if there is no display."""
    if not _has_screen():
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    return importlib.import_module("pyvista")


def _has_screen() -> bool:
    """True if a server answers at DISPLAY; if none did, VTK would complain on stderr."""
    import socket

    host, colon, screen = os.environ.get("DISPLAY", "").rpartition(":")
    number = screen.partition(".")[0]
    if not (colon and number.isdecimal()):
        return False
    is_local = host in ("", "unix")
    path, server = f"/tmp/.X11-unix/X{number}", (host, 6000 + int(number))
    try:
        with socket.socket(socket.AF_UNIX if is_local else socket.AF_INET) as probe:
            probe.settimeout(1.0)
            probe.connect(path if is_local else server)
    except OSError:
        return False
    return True


def compile_always() -> None:
    """Let numba compile without a cache: with no writable folder it would refuse to work."""
    from numba.core.dispatcher import Dispatcher

    setattr(Dispatcher, "enable_caching", lambda self: None)  # noqa: B010


def load_extra(module: str, extra: str) -> ModuleType:
    """A library that only the extra `extra` installs.

    Raises
    ------
    MissingLibraryError
        With the command that installs it.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingLibraryError(
            f"{module.partition('.')[0]} is not installed; run: pip install 'recon-stereo[{extra}]'"
        ) from error


def check_extra(module: str, extra: str) -> None:
    """Raise `MissingLibraryError` if a library is not installed, without loading it."""
    if importlib.util.find_spec(module) is None:
        load_extra(module, extra)


def open3d_fault() -> str | None:
    """The reason why Open3D does not load, with the command that fixes it; None if it loads."""
    try:
        load_open3d()
    except MissingLibraryError as error:
        return str(error)
    return None


@functools.cache
def rendering_fault() -> str | None:
    """The reason why rendering fails, with the command that fixes it; None if it works."""
    result = subprocess.run(
        [sys.executable, "-c", _RENDER_PROBE], capture_output=True, text=True, check=False
    )
    if result.returncode == 0:
        return None
    return f"rendering does not work (exit {result.returncode}); run: {APT_LINE}"


@contextmanager
def listening_to_compiler(begin: Callable[[], None], end: Callable[[], None]) -> Iterator[None]:
    """Call `begin` and `end` around each compilation by numba inside the block."""
    event = importlib.import_module("numba.core.event")

    class Ear(event.Listener):  # type: ignore[name-defined,misc]
        def on_start(self, _event: object) -> None:
            begin()

        def on_end(self, _event: object) -> None:
            end()

    with event.install_listener("numba:compile", Ear()):
        yield


THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
)


def limit_threads(number: int) -> None:
    """Limit every library of this process to `number` threads.

    Most libraries read their limit when imported, so call this first.
    """
    for name in THREAD_VARIABLES:
        os.environ[name] = str(number)
    import cv2

    cv2.setNumThreads(number)


_M_ARENA_MAX = -8
"""Parameter of glibc's `mallopt`."""
_NUM_ARENAS = 2


def share_arenas() -> None:
    """Let all threads allocate in few arenas: what one frees the next one uses.

    glibc makes an arena for every thread otherwise, and a program that starts threads all the time
    grows. Elsewhere nothing happens.
    """
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, _NUM_ARENAS)


_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3
_KEPT_BYTES, _LARGEST_KEPT = 1 << 30, 32 << 20
"""Free memory that a process keeps, and the largest array in it that glibc allows."""


def keep_memory() -> None:
    """Keep free memory for the next array: the system would have to clear it again.

    For processes that end soon. Elsewhere than with glibc nothing happens.
    """
    with suppress(AttributeError, OSError, TypeError):
        library = ctypes.CDLL(None)
        library.mallopt(_M_MMAP_THRESHOLD, _LARGEST_KEPT)
        library.mallopt(_M_TRIM_THRESHOLD, _KEPT_BYTES)


@contextmanager
def memory_kept() -> Iterator[None]:
    """Keep free memory inside the block, for work in many steps that each need as much again."""
    keep_memory()
    try:
        yield
    finally:
        with suppress(AttributeError, OSError, TypeError):
            # As glibc itself has it after the largest array.
            ctypes.CDLL(None).mallopt(_M_TRIM_THRESHOLD, 2 * _LARGEST_KEPT)
        return_memory()


def return_memory() -> None:
    """Return free memory to the system, if the C library can."""
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


@contextmanager
def silent() -> Iterator[None]:
    """Suppress the output of compiled code to stdout and stderr inside the block."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        yield
    finally:
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)
