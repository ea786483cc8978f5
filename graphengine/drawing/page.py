"""A drawing as one HTML file: the SVG with pan, zoom, and a line with details of the selected element.

The file opens from disk and makes no network requests. Its content security policy allows only one script and two style sheets,
given by their digests.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from importlib import resources
from string import Template

from graphengine.drawing import svg
from graphengine.drawing.view_model import GraphView


def draw(views: Sequence[GraphView]) -> str:
    """Return a page with all graphs, one below the other.

    Raises:
        UsageError: the layout library is not installed.
    """
    drawing = svg.draw(views)
    folder = resources.files(__package__)
    style, script = (folder.joinpath(name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    title = svg.escape(", ".join(view.title for view in views))
    policy = f"default-src 'none'; script-src {digest(script)}; style-src {digest(style)} {digest(svg.STYLE)}; "
    policy += "base-uri 'none'; form-action 'none'"
    page = Template(folder.joinpath("page.html").read_text(encoding="utf-8"))
    return page.substitute(policy=policy, title=title, style=style, drawing=drawing, script=script)


def digest(text: str) -> str:
    """Return the digest of a script or style sheet in the form of a content security policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
