"""Access to the ports that graphrun serves: tokens in printed addresses, and JSON objects from clients."""

from __future__ import annotations

import hmac
import json
import secrets
from collections.abc import Mapping
from typing import Any


def make_token() -> str:
    """Return a new random token of 32 characters, none of which needs an escape in URLs."""
    return secrets.token_urlsafe(24)


def has_token(target: str, token: str) -> bool:
    """Return whether the field `token` in the query of a request is this token. Compares in constant time; never raises.

    Args:
        target: path and query of the request, with any characters, even surrogates.
        token: the expected token.
    """
    fields = [part.partition("=") for part in target.partition("?")[2].split("&")]
    given = [value.encode(errors="surrogatepass") for name, _, value in fields if name == "token"]
    return sum(hmac.compare_digest(value, token.encode()) for value in given) > 0  # without an early end


def parse_object(text: str | bytes) -> Mapping[str, Any] | None:
    """Return the JSON object in a client's text; None for any other text."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None
