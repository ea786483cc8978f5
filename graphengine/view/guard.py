"""Decides who may load the page: requests must carry its token and come from the page itself."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit


@dataclass(frozen=True, slots=True)
class Refusal:
    """The response to a refused request."""

    status: int
    reason: str


@dataclass(frozen=True, slots=True)
class Welcome:
    """A redirect with a cookie: the response to a request with the token in its URL. Later requests have only the cookie."""

    location: str
    cookie: str


@dataclass(frozen=True, slots=True)
class PageGuard:
    """Checks each HTTP request and each WebSocket handshake.

    Each request needs the token: the first request in its URL, later requests in a cookie. `Host` must be one of the page's
    names; this prevents DNS rebinding, in which a foreign name resolves to this machine. `Origin`, if given, must be the page
    itself, so that other pages in the same browser have no access.

    Attributes:
        hosts: legal values of `Host`, in the form `name:port`; the user sees the first value.
        every_address: whether the page is served on all IP addresses of the machine. Then any IP address is a legal host,
            because DNS rebinding needs a name.
        token: shared secret, new in each process.
    """

    hosts: tuple[str, ...]
    every_address: bool = False
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)

    @property
    def cookie(self) -> str:
        """Name of the cookie; it contains the port, because a browser shares cookies between all ports of a host."""
        return f"graphrun_{self.hosts[0].rpartition(':')[2]}"

    def check(self, target: str, headers: Mapping[str, str]) -> Refusal | Welcome | None:
        """Check a request. Return None to accept it, otherwise the response to send.

        Args:
            target: path and query of the URL.
            headers: headers by name; look-ups must ignore the case of names.
        """
        host = headers.get("Host", "")
        if not self._is_own(host):
            return Refusal(403, self._other_name(host))
        origin = headers.get("Origin")
        if origin is not None and not (origin.startswith("http://") and self._is_own(origin.removeprefix("http://"))):
            return Refusal(403, "the request comes from another page")
        parts = urlsplit(target)
        query = parse_qs(parts.query)
        if any(map(self._is_token, query.get("token", ()))):
            return Welcome(parts.path, f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict")
        if not any(map(self._is_token, _cookies(headers.get("Cookie", ""), self.cookie))):
            return Refusal(403, "open the address that graphrun printed: it contains the token of this run")
        return None

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

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self.token.encode())


def _is_loopback(name: str) -> bool:
    return name == "localhost" or (_is_address(name) and ipaddress.ip_address(name).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _cookies(text: str, name: str) -> Iterable[str]:
    try:
        found = SimpleCookie(text).get(name)
    except CookieError:
        return ()
    return (found.value,) if found is not None else ()
