"""Creates off-screen OpenGL contexts with EGL, or with OSMesa as a fallback.

MuJoCo draws into the current context of its thread. MuJoCo's own context classes use PyOpenGL, which supports only one of the two
platforms per process, and an environment variable must select it before the import. So this module calls the few functions that
it needs through ctypes, and supports both platforms.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
from collections.abc import Iterator
from contextlib import AbstractContextManager
from typing import Any

from graphengine.format.errors import RenderError
from graphengine.format.process_limits import has_address_space

ADDRESS_SPACE = 1_100_000_000
"""Address space that Mesa's software renderer needs, bytes; with less, it fails without a reason or crashes."""
_Handle, _Unsigned, _Integer = ctypes.c_void_p, ctypes.c_uint, ctypes.c_int32
_RENDERER, _VERSION = 0x1F01, 0x1F02
INSTALL = (
    "on Debian and Ubuntu: apt-get install libegl1 libgl1-mesa-dri libopengl0",
    "or, where there is no EGL: apt-get install libosmesa6",
)
"""Remedies for a machine on which off-screen OpenGL does not work."""


def context() -> AbstractContextManager[None]:
    """Return a context manager that makes an OpenGL context current in the calling thread, and destroys it at the end.

    Raises:
        RenderError: off-screen OpenGL does not work here, or it was first used before this process was forked.
    """
    return _own_platform().context()


def driver() -> str:
    """Return name and version of the OpenGL driver; images of different drivers differ in their last bits.

    Raises:
        RenderError: off-screen OpenGL does not work here; see `context`.
    """
    platform = _own_platform()
    with platform.context():
        get_string = ctypes.CFUNCTYPE(ctypes.c_char_p, _Unsigned)(platform.address("glGetString"))
        return ", ".join((get_string(name) or b"?").decode(errors="replace") for name in (_RENDERER, _VERSION))


class _UnusableError(Exception):
    """The library of a platform exists, but cannot be used."""


def _own_platform() -> _Egl | _OSMesa:
    platform, process = _platform()
    if process != os.getpid():  # the driver's threads are not in the copy, which would wait for them for ever
        raise RenderError(
            "images were rendered before this process was forked, and OpenGL drivers do not work after a fork\n"
            "use the start method 'spawn' or 'forkserver' of multiprocessing"
        )
    return platform


@functools.cache
def _platform() -> tuple[_Egl | _OSMesa, int]:
    """Return the first platform (EGL or OSMesa) that works, and the id of the process in which it was opened.

    Raises MemoryError if too little address space is free.

    The result is cached, because MuJoCo looks up the platform's OpenGL functions only once per process.
    """
    if not has_address_space(ADDRESS_SPACE):
        needed = f"rendering images needs {ADDRESS_SPACE // 10**6} MB of address space"
        raise MemoryError(f"{needed}; raise the limit of `ulimit -v`")
    failures: list[str] = []
    for name, platform in (("EGL", _Egl), ("OSMesa", _OSMesa)):
        try:
            return platform(), os.getpid()
        except (OSError, AttributeError, _UnusableError) as error:  # not there, too old, or broken
            failures.append(f"{name}: {error}")
    raise RenderError("\n".join(("rendering images needs OpenGL, which does not work here", *failures, *INSTALL)))


def _function(library: ctypes.CDLL, name: str, result: Any, *arguments: Any) -> Any:
    function = getattr(library, name)
    function.restype, function.argtypes = result, arguments
    return function


class _Egl:
    """EGL on the first device that supports OpenGL; GPUs come before Mesa's software renderer."""

    DEVICE_PLATFORM, OPENGL = 0x313F, 0x30A2
    # 8 bits each of red, green, blue and alpha, a depth of 24, a stencil of 8; for OpenGL, off-screen.
    WANTED = (0x3024, 8, 0x3023, 8, 0x3022, 8, 0x3021, 8, 0x3025, 24, 0x3026, 8, 0x3040, 8, 0x3033, 1, 0x3038)

    def __init__(self) -> None:
        find = functools.partial(_function, ctypes.CDLL("libEGL.so.1"))
        self._address = find("eglGetProcAddress", _Handle, ctypes.c_char_p)
        self._bind = find("eglBindAPI", _Unsigned, _Unsigned)
        self._choose = find("eglChooseConfig", _Unsigned, _Handle, _Handle, _Handle, _Integer, _Handle)
        self._create = find("eglCreateContext", _Handle, _Handle, _Handle, _Handle, _Handle)
        self._destroy = find("eglDestroyContext", _Unsigned, _Handle, _Handle)
        self._initialize = find("eglInitialize", _Unsigned, _Handle, _Handle, _Handle)
        self._make_current = find("eglMakeCurrent", _Unsigned, _Handle, _Handle, _Handle, _Handle)
        self._release_thread = find("eglReleaseThread", _Unsigned)
        self._display, self._config = self._usable()
        # MuJoCo finds OpenGL in what the whole process sees, and NVIDIA's driver needs libOpenGL there for several threads.
        ctypes.CDLL("libEGL.so.1", mode=ctypes.RTLD_GLOBAL)
        with contextlib.suppress(OSError):
            ctypes.CDLL("libOpenGL.so.0", mode=ctypes.RTLD_GLOBAL)

    def _usable(self) -> tuple[int, int]:
        """Return display and configuration of the first device with which a context can be created."""
        query = self._extension("eglQueryDevicesEXT", _Unsigned, _Integer, _Handle, _Handle)
        display_of = self._extension("eglGetPlatformDisplayEXT", _Handle, _Unsigned, _Handle, _Handle)
        devices, count = (_Handle * 32)(), _Integer()
        query(len(devices), devices, ctypes.byref(count))
        for device in devices[: count.value]:
            display = display_of(self.DEVICE_PLATFORM, device, None)
            config = self._configure(display) if display and self._initialize(display, None, None) else None
            made = self._create(display, config, None, None) if config else None
            if config and made:
                self._destroy(display, made)
                return display, config
        raise _UnusableError(f"none of {count.value} devices supports OpenGL")

    def _extension(self, name: str, result: Any, *arguments: Any) -> Any:
        return ctypes.CFUNCTYPE(result, *arguments)(self.address(name))

    def address(self, function: str) -> int:
        """Return the address of an EGL or OpenGL function."""
        found: int | None = self._address(function.encode())
        if not found:
            raise _UnusableError(f"the driver does not have the function {function}")
        return found

    def _configure(self, display: int) -> int | None:
        config, found = _Handle(), _Integer()
        wanted = (_Integer * len(self.WANTED))(*self.WANTED)
        self._choose(display, wanted, ctypes.byref(config), 1, ctypes.byref(found))
        return config.value if found.value and self._bind(self.OPENGL) else None

    @contextlib.contextmanager
    def context(self) -> Iterator[None]:
        """Create an OpenGL context, make it current in the calling thread, and destroy it when the `with` block ends."""
        self._bind(self.OPENGL)  # a thread's own setting
        made = self._create(self._display, self._config, None, None)
        if not made or not self._make_current(self._display, None, None, made):
            raise RenderError("EGL: the driver cannot create another context")
        try:
            yield
        finally:
            self._make_current(self._display, None, None, None)
            self._destroy(self._display, made)
            self._release_thread()


class _OSMesa:
    """OSMesa: Mesa's software renderer, which does not need a display or device."""

    RGBA, UNSIGNED_BYTE = 0x1908, 0x1401
    SIDE = 16
    """Side of the image buffer that OSMesa needs instead of a window, pixels; MuJoCo draws into its own buffers."""

    def __init__(self) -> None:
        find = functools.partial(_function, self._library())
        self._create = find("OSMesaCreateContextExt", _Handle, _Unsigned, _Integer, _Integer, _Integer, _Handle)
        self._destroy = find("OSMesaDestroyContext", None, _Handle)
        self._make_current = find("OSMesaMakeCurrent", ctypes.c_ubyte, _Handle, _Handle, _Unsigned, _Integer, _Integer)
        self._address = find("OSMesaGetProcAddress", _Handle, ctypes.c_char_p)

    def address(self, function: str) -> int:
        """Return the address of an OpenGL function."""
        found: int = self._address(function.encode())
        return found

    def _library(self) -> ctypes.CDLL:
        with contextlib.suppress(OSError):
            return ctypes.CDLL("libOSMesa.so.6", mode=ctypes.RTLD_GLOBAL)
        return ctypes.CDLL("libOSMesa.so.8", mode=ctypes.RTLD_GLOBAL)

    @contextlib.contextmanager
    def context(self) -> Iterator[None]:
        """Create an OpenGL context, make it current in the calling thread, and destroy it when the `with` block ends."""
        window = (ctypes.c_ubyte * (4 * self.SIDE * self.SIDE))()
        made = self._create(self.RGBA, 24, 8, 0, None)
        if not made or not self._make_current(made, window, self.UNSIGNED_BYTE, self.SIDE, self.SIDE):
            raise RenderError("OSMesa: the driver cannot create a context")
        try:
            yield
        finally:
            self._make_current(None, None, self.UNSIGNED_BYTE, 0, 0)
            self._destroy(made)
