"""Which requests the port of the page accepts: the names of the page, and the token for the data of the run."""

from __future__ import annotations

import pytest

from graphengine.view.guard import PageGuard

HOST = "127.0.0.1:8000"
GUARD = PageGuard((HOST, "localhost:8000"), token="3uHc1Zx8fWq0s-Vb_T5mYdK2rJ7nLpQa")
FEED = f"/feed?token={GUARD.token}"
HOSTS = [("Host", HOST)]


@pytest.mark.parametrize("host", GUARD.hosts)
@pytest.mark.parametrize("origin", [[], [("Origin", f"http://{HOST}")], [("origin", "http://localhost:8000")]])
@pytest.mark.parametrize("target", [FEED, f"/3d?darkMode&token={GUARD.token}", f"/feed?token=&token={GUARD.token}"])
def test_with_the_token_a_request_is_let_in_under_each_name(
    host: str, origin: list[tuple[str, str]], target: str
) -> None:
    assert GUARD.check(target, [("host", host), *origin], secret=True) == ""


@pytest.mark.parametrize(
    "headers",
    [
        [],
        [("Host", "")],
        [("Host", "evil.example:8000")],
        [("Host", "127.0.0.1:8001")],
        [("Host", "[")],
        [("Host", HOST), ("Host", HOST)],
        [("Host", HOST), ("host", "evil.example")],
        [*HOSTS, ("Origin", "http://evil.example")],
        [*HOSTS, ("Origin", "null")],
        [*HOSTS, ("Origin", "")],
        [*HOSTS, ("Origin", f"https://{HOST}")],
        [*HOSTS, ("Origin", f"http://{HOST}"), ("Origin", f"http://{HOST}")],
        [*HOSTS, ("Origin", f"http://{HOST}"), ("ORIGIN", "http://evil.example")],
        [*HOSTS, ("Origin", "http://\udcff")],
    ],
)
@pytest.mark.parametrize("secret", [True, False])
def test_from_another_name_or_page_nothing_is_let_in(headers: list[tuple[str, str]], secret: bool) -> None:
    assert GUARD.check(FEED, headers, secret=secret)


@pytest.mark.parametrize(
    "target",
    [
        "/feed",
        "/feed?token=",
        f"/feed?token={GUARD.token[:-1]}",
        f"/feed?token={GUARD.token}x",
        f"/feed?tokens={GUARD.token}",
        f"/feed#token={GUARD.token}",
        f"/feed?x={GUARD.token}",
        f"/{GUARD.token}",
        "/feed?token=ü",
        "/feed?token=\udcff\udcfe",
        "/feed?token=\ud800",
        "/feed?token=%00%ff",
        "//[",
        "//[?token=]",
        "",
        "?" * 8000,
        "&" * 8000,
        "/feed?" + "token=x&" * 1000,
    ],
)
def test_without_the_token_no_data_is_sent_whatever_a_stranger_writes(target: str) -> None:
    cookies = [("Cookie", f"graphrun_8000={GUARD.token}"), ("Cookie", f"token={GUARD.token}")]
    assert GUARD.check(target, [*HOSTS, *cookies], secret=True)
    assert GUARD.check(target, HOSTS, secret=False) == ""


@pytest.mark.parametrize("host", ["localhost:9000", "127.0.0.1:9000", "[::1]:9000"])
def test_a_port_that_is_forwarded_to_another_one_is_refused_with_what_to_do(host: str) -> None:
    assert "ssh -L 8000:127.0.0.1:8000" in GUARD.check(FEED, [("Host", host)], secret=False)


@pytest.mark.parametrize("host", ["192.168.1.5:8000", "[fe80::1]:8000", "machine:8000"])
def test_a_page_on_every_address_takes_addresses_for_names(host: str) -> None:
    guard = PageGuard(("machine:8000", "localhost:8000"), every_address=True)
    target = f"/feed?token={guard.token}"
    assert guard.check(target, [("Host", host), ("Origin", f"http://{host}")], secret=True) == ""
    for other in ("evil.example:8000", "192.168.1.5:8001", "192.168.1.5"):
        assert guard.check(target, [("Host", other)], secret=True)
        assert guard.check(target, [("Host", host), ("Origin", f"http://{other}")], secret=True)


def test_another_process_has_another_token() -> None:
    assert PageGuard((HOST,)).token != GUARD.token
    assert GUARD.token not in repr(GUARD)
