"""Mutants of a small module."""

from __future__ import annotations

import ast
from textwrap import dedent

from tests.bench.mutation import mutants, places, replaced

MODULE = ast.parse(
    dedent(
        """
        class Tank:
            def fill(self, litres):
                'Fill, and return the level.'
                if litres > self.room:
                    raise ValueError(f"only {self.room + 1}")
                self.level = self.level + litres
                self.notify(self.level, litres)
                return self.level * 60
        """
    )
)


def test_each_kind_of_mutant_is_found_and_messages_have_none() -> None:
    found = [(kind, after) for _, body, index in places(MODULE) for kind, _, after in mutants(body, index)]
    assert found == [
        ("bound", "if litres >= self.room:\n    pass"),
        ("sign", "self.level = self.level - litres"),
        ("order", "self.notify(self.level, litres)\nself.level = self.level + litres"),
        ("call", "pass"),
        ("order", "self.notify(litres, self.level)"),
        ("sign", "return -self.level * 60"),
        ("constant", "return self.level * 61"),
    ]


def test_a_compound_statement_keeps_its_body_and_is_found_in_its_function_only() -> None:
    tree = ast.parse("def fill(a):\n    if a > 1:\n        a = 2\n    else:\n        a = 3\n")
    wanted = ("if a > 1:\n    pass", "if a >= 1:\n    pass")
    assert not replaced(tree, "drain", *wanted)
    assert replaced(tree, "fill", *wanted)
    assert ast.unparse(tree) == "def fill(a):\n    if a >= 1:\n        a = 2\n    else:\n        a = 3"
    assert not replaced(tree, "fill", *wanted)


def test_two_statements_change_places() -> None:
    tree = ast.parse("def fill():\n    a = 1\n    b = a\n    c = b\n")
    assert replaced(tree, "fill", "b = a\nc = b", "c = b\nb = a")
    assert ast.unparse(tree) == "def fill():\n    a = 1\n    c = b\n    b = a"
