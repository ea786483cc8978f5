"""Decides which requests the page's port accepts: those for the page itself, and for its data those with the token."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterable
from dataclasses import dataclass, field

from graphengine.format.web_access import has_token, make_token


@dataclass(frozen=True, slots=True)
class PageGuard:
    """Checks each HTTP request and each WebSocket handshake. `check` never raises, whatever a stranger sends.

    `Host` must be one of the page's names; this prevents DNS rebinding, in which a foreign name resolves to this machine.
    `Origin`, if given, must be the page itself, so that other pages in the same browser have no access. Requests for data of the
    run need the token in their query. No cookie carries it, because a browser sends cookies to all ports of a host.

    Attributes:
        hosts: legal values of `Host`, in the form `name:port`; the user sees the first value.
        every_address: whether the page is served on all IP addresses of the machine. Then any IP address is a legal host,
            because DNS rebinding needs a name.
        token: shared secret.
    """

    hosts: tuple[str, ...]
    every_address: bool = False
    token: str = field(default_factory=make_token, repr=False)

    def check(self, target: str, headers: Iterable[tuple[str, str]], *, secret: bool) -> str:
        """Check a request. Return the reason to refuse it with status 403; an empty text accepts it.

        Args:
            target: path and query of the URL.
            headers: names and values of all headers; a name may occur several times.
            secret: whether the response has data of the run, so that the request needs the token.
        """
        given = [(name.lower(), value) for name, value in headers]
        hosts, origins = ([value for name, value in given if name == wanted] for wanted in ("host", "origin"))
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return self._other_name(hosts[0] if hosts else "")
        own = [origin.startswith("http://") and self._is_own(origin.removeprefix("http://")) for origin in origins]
        if own not in ([], [True]):
            return "the request comes from another page"
        if secret and not has_token(target, self.token):
            return "open the address that graphrun printed: it contains the token of this run"
        return ""

    def _other_name(self, host: str) -> str:
        """Return the reason why a host name is refused, and a remedy; a loopback name means that the port was forwarded."""
        port = self.hosts[0].rpartition(":")[2]
        if _is_loopback(host.rpartition(":")[0].strip("[]")):
            forward = f"ssh -L {port}:127.0.0.1:{port} MACHINE"
            then = "and open the address that graphrun printed"
            return f"this page is on port {port}; forward the same port, as in `{forward}`, {then}"
        return "this page has another host name: open the address that graphrun printed"

    def _is_own(self, host: str) -> bool:
        name, _, port = host.rpartition(":")
        return host in self.hosts or (
            self.every_address and port == self.hosts[0].rpartition(":")[2] and _is_address(name.strip("[]"))
        )


def _is_loopback(name: str) -> bool:
    return name == "localhost" or (_is_address(name) and ipaddress.ip_address(name).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
