"""One-file HTML page of a drawing: the SVG with pan, zoom and a line of text about the selected element.

It opens from disk and asks the network for nothing: its policy lets run one script and two style sheets, by their digests.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from importlib import resources

from graphengine.drawing import svg
from graphengine.drawing.view_model import GraphView

_HINT = "Drag or arrow keys: move. Wheel, + and -: zoom. 0: everything. Tab: next node. Click: what it is."


def draw(views: Sequence[GraphView]) -> str:
    """One page with all graphs, one below the other.

    Raises:
        UsageError: the layout library is not installed.
    """
    drawing = svg.draw(views)
    folder = resources.files(__package__)
    style, script = (folder.joinpath(name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    title = svg.escape(", ".join(view.title for view in views))
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src {_digest(script)}",
            f"style-src {_digest(style)} {_digest(svg.STYLE)}",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<header>
<button id="closer" aria-label="zoom in">+</button>
<button id="farther" aria-label="zoom out">&minus;</button>
<button id="whole">everything</button>
<p>{_HINT}</p>
</header>
<main id="drawing">
{drawing}</main>
<pre id="about" tabindex="0" role="status">{title}</pre>
<script>{script}</script>
</body>
</html>
"""


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
