"""`python -m tests.docs.generate` writes the generated pages of docs/reference."""

from __future__ import annotations

from tests.docs.generate.all_pages import write

if __name__ == "__main__":
    write()
