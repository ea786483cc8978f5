"""Captures the log of Cyclone DDS, and counts malformed messages: Cyclone logs each malformed message that it drops.

Cyclone logs to a file in memory, which this module reads from time to time. A log callback could deadlock: the callback would
wait for Python's GIL while its thread holds Cyclone's locks, and the thread with the GIL would wait for these locks in a write.
"""

from __future__ import annotations

import ctypes
import logging
import os
import platform
import re
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from graphengine.format.wording import printable
from graphengine.messages import names

_log = logging.getLogger(__name__)

_MAX_SIZE = 1 << 20
"""Size above which the log file is emptied after reading, bytes."""
_LINE = re.compile(r"[0-9.]+ \[(?P<domain>[0-9]+)\] +\S+ *(?P<text>.*)")
_MALFORMED = re.compile(r"deserialization (?P<topic>r[tqr]/\S+)/\S+ failed")
_VARYING = re.compile(r"<.*|\b[0-9a-f]+\b|[0-9a-f]*[0-9][0-9a-f]*")
"""Text that varies between log lines of one kind: numbers, and the content of a packet, from `<` to the end of the line."""
MAX_KINDS = 20
"""Maximum number of kinds of log lines of which one line is logged; lines of further kinds are only counted."""
PERIOD = 60.0
"""Minimum time between two reports of the number of lines that were not logged, s."""


class CycloneLog:
    """The log of all domains in this process. The log can be captured only with glibc; otherwise Cyclone prints it to stderr."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._file: int | None = None
        self._stream: int | None = None
        self._rest = b""
        self._position = 0
        self._kinds: set[str] = set()
        self._unlogged = 0
        self._due = 0.0
        self._malformed: dict[int, Counter[str]] = {}

    @contextmanager
    def capture(self) -> Iterator[None]:
        """Return a context in which the C library's `stderr` is replaced, so that new domains log to this object.

        Cyclone has no setting for this: a domain always logs to the stream that was `stderr` when the domain was created.
        """
        if platform.libc_ver()[0] != "glibc":
            yield
            return
        library = ctypes.CDLL(None)
        stderr = ctypes.c_void_p.in_dll(library, "stderr")
        with self._lock:
            if self._file is None:
                self._file = os.memfd_create("cyclone")
                library.fdopen.restype = ctypes.c_void_p
                self._stream = library.fdopen(self._file, b"a")
            before, stderr.value = stderr.value, self._stream
            try:
                yield
            finally:
                stderr.value = before

    def reason(self) -> str:
        """Return the text of the newest log line, which says why a domain could not be created; empty without new lines."""
        with self._lock:
            lines = self._lines()
        return _text(lines[-1]) if lines else ""

    def malformed(self, domain_id: int) -> Mapping[str, int]:
        """Read the log; return the number of malformed messages of each topic or service, and log one other line of each kind."""
        with self._lock:
            for line in self._lines():
                self._note(line)
            if self._unlogged and time.monotonic() >= self._due:
                self._due = time.monotonic() + PERIOD
                _log.warning("Cyclone DDS: %d further log lines are not shown", self._unlogged)
                self._unlogged = 0
            return dict(self._malformed.get(domain_id, {}))

    def forget(self, domain_id: int) -> None:
        """Discard the counts of a domain; called when this process has left the domain."""
        self.malformed(domain_id)
        with self._lock:
            self._malformed.pop(domain_id, None)

    def _lines(self) -> list[str]:
        if self._file is None:
            return []
        while read := os.pread(self._file, _MAX_SIZE, self._position):
            self._position += len(read)
            self._rest += read
        if self._position > _MAX_SIZE:
            os.ftruncate(self._file, 0)  # Cyclone appends, so it continues at the new end
            self._position = 0
        *lines, self._rest = self._rest.split(b"\n")
        return [line.decode(errors="replace") for line in lines]

    def _note(self, line: str) -> None:
        parts = _LINE.match(line)
        fault = _MALFORMED.search(line)
        if parts and fault:
            self._malformed.setdefault(int(parts["domain"]), Counter())[printable(names.ros_name(fault["topic"]))] += 1
        else:
            text = _text(line)
            kind = _VARYING.sub("", text)
            if kind not in self._kinds and len(self._kinds) < MAX_KINDS:
                self._kinds.add(kind)
                _log.warning("Cyclone DDS: %s", printable(text))
            elif kind not in self._kinds:
                self._unlogged += 1


def _text(line: str) -> str:
    """Return the text of a log line without its prefix of time, domain and thread."""
    parts = _LINE.match(line)
    return parts["text"] if parts else line


LOG = CycloneLog()
