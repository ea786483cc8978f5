"""Who may load the page: the token, the cookie that takes its place, and the names under which the page is served."""

from __future__ import annotations

import pytest

from graphengine.view.guard import PageGuard, Refusal, Welcome

HOST = "127.0.0.1:8000"
GUARD = PageGuard((HOST, "localhost:8000"), token="3uHc1Zx8fWq0s-Vb_T5mYdK2rJ7nLpQa")
COOKIE = f"{GUARD.cookie}={GUARD.token}"


def test_the_first_request_brings_the_token_and_gets_a_cookie() -> None:
    verdict = GUARD.check(f"/?token={GUARD.token}", {"Host": HOST})
    assert isinstance(verdict, Welcome)
    assert verdict.location == "/"
    assert verdict.cookie == f"{COOKIE}; Path=/; HttpOnly; SameSite=Strict"


@pytest.mark.parametrize("host", GUARD.hosts)
@pytest.mark.parametrize("origin", [{}, {"Origin": f"http://{HOST}"}, {"Origin": "http://localhost:8000"}])
def test_with_the_cookie_a_request_is_let_in_under_each_name(host: str, origin: dict[str, str]) -> None:
    assert GUARD.check("/feed", {"Host": host, "Cookie": f"other=1; {COOKIE}", **origin}) is None


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": HOST},
        {"Host": HOST, "Cookie": f"{GUARD.cookie}="},
        {"Host": HOST, "Cookie": f"{GUARD.cookie}={GUARD.token[:-1]}"},
        {"Host": HOST, "Cookie": f"graphrun_8001={GUARD.token}"},
        {"Host": HOST, "Cookie": "\x00=;;=;"},
        {"Host": "evil.example:8000", "Cookie": COOKIE},
        {"Host": "127.0.0.1:8001", "Cookie": COOKIE},
        {"Cookie": COOKIE},
        {"Host": HOST, "Cookie": COOKIE, "Origin": "http://evil.example"},
        {"Host": HOST, "Cookie": COOKIE, "Origin": "null"},
        {"Host": HOST, "Cookie": COOKIE, "Origin": f"https://{HOST}"},
    ],
)
def test_without_it_or_from_elsewhere_a_request_is_refused(headers: dict[str, str]) -> None:
    verdict = GUARD.check("/", headers)
    assert isinstance(verdict, Refusal)
    assert verdict.status == 403


@pytest.mark.parametrize("host", ["localhost:9000", "127.0.0.1:9000", "[::1]:9000"])
def test_a_port_that_is_forwarded_to_another_one_is_refused_with_what_to_do(host: str) -> None:
    verdict = GUARD.check(f"/?token={GUARD.token}", {"Host": host})
    assert isinstance(verdict, Refusal)
    assert "ssh -L 8000:127.0.0.1:8000" in verdict.reason


@pytest.mark.parametrize("host", ["192.168.1.5:8000", "[fe80::1]:8000", "machine:8000"])
def test_a_page_on_every_address_takes_addresses_for_names(host: str) -> None:
    guard = PageGuard(("machine:8000", "localhost:8000"), every_address=True)
    cookie = f"{guard.cookie}={guard.token}"
    assert guard.check("/", {"Host": host, "Origin": f"http://{host}", "Cookie": cookie}) is None
    for other in ("evil.example:8000", "192.168.1.5:8001", "192.168.1.5"):
        assert isinstance(guard.check("/", {"Host": other, "Cookie": cookie}), Refusal)
        assert isinstance(guard.check("/", {"Host": host, "Origin": f"http://{other}", "Cookie": cookie}), Refusal)


@pytest.mark.parametrize("token", ["", "x", GUARD.token[:-1], f"{GUARD.token}x", "ü"])
def test_a_wrong_token_is_refused(token: str) -> None:
    assert isinstance(GUARD.check(f"/?token={token}", {"Host": HOST}), Refusal)


def test_another_process_has_another_token() -> None:
    assert PageGuard((HOST,)).token != GUARD.token
    assert GUARD.token not in repr(GUARD)
