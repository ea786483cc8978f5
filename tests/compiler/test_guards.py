"""Which flags imply which: compared with all ways in which the flags can be set."""

from __future__ import annotations

from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.compiler.planning.guards import GuardTree


def implied(causes: dict[str, list[str]]) -> dict[str, set[str]]:
    """For each flag: itself, and what all of its causes imply."""
    found = {"": {""}}
    for flag, before in causes.items():
        found[flag] = {flag} | set.intersection(*(found[cause] for cause in before))
    return found


@settings(max_examples=200)
@given(st.randoms(use_true_random=False), st.integers(1, 40))
def test_a_flag_implies_what_all_of_its_causes_imply(random: Random, size: int) -> None:
    tree, causes = GuardTree(), dict[str, list[str]]()
    for number in range(size):
        known = ["", *causes]
        near = known[-random.randint(1, len(known)) :]
        causes[f"f{number}"] = [random.choice(near) for _ in range(random.choice((1, 1, 2, 3)))]
        tree.add(f"f{number}", causes[f"f{number}"])
    tree.number()
    rules, flags, members = implied(causes), list[int](), set[str]()
    for flag in random.choices(["", *causes], k=12):
        expected = bool(rules[flag] & members)
        assert tree.implies(flag, flags) == expected
        if not expected:
            tree.include(flag, flags)
            members.add(flag)


def test_a_flag_deep_below_two_long_rows_implies_the_flag_above_both() -> None:
    tree = GuardTree()
    tree.add("top", [""])
    for row in "ab":
        for number in range(3000):
            tree.add(f"{row}{number}", [f"{row}{number - 1}" if number else "top"])
    tree.add("joined", ["a2999", "b1500"])
    tree.number()
    flags = list[int]()
    tree.include("top", flags)
    assert tree.implies("joined", flags)
    others = list[int]()
    tree.include("a0", others)
    assert not tree.implies("joined", others)
