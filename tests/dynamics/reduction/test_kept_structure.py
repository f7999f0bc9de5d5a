"""Bodies and stress recovery kept between runs: for the same sections alone, and for as many rolls as wanted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from wroll_fem.dynamics.reduction.kept_structure import keeping_structure, kept_bodies, kept_stresses


def roll(text: str, file: str | None = None) -> Any:
    return SimpleNamespace(structure_text=text, mesh=SimpleNamespace(file=file))


def bodies_of(text: str, *, half: bool = False, file: str | None = None) -> list[Any]:
    return kept_bodies(roll(text, file), half, lambda: [object()])


def test_a_series_keeps_the_bodies_of_the_last_roll() -> None:
    with keeping_structure():
        first = bodies_of("a")
        assert bodies_of("a") is first
        assert bodies_of("a", half=True) is not first
        assert bodies_of("a") is not first  # half of the roll was the last
        of_file = bodies_of("b", file="own.msh")
        assert bodies_of("b", file="own.msh") is of_file


def test_many_runs_keep_the_bodies_of_the_latest_rolls_but_not_those_of_a_file() -> None:
    with keeping_structure(2, bodies_alone=True):
        a, b = bodies_of("a"), bodies_of("b")
        assert bodies_of("a") is a
        bodies_of("c")  # the third: b was used longest ago
        assert bodies_of("a") is a
        assert bodies_of("b") is not b
        assert bodies_of("d", file="own.msh") is not bodies_of("d", file="own.msh")


def test_the_recovery_of_stresses_belongs_to_its_bodies() -> None:
    computed = []

    def compute() -> Any:
        computed.append(object())
        return (computed[-1],)

    with keeping_structure():
        bodies = bodies_of("a")
        assert kept_stresses(bodies, compute) is kept_stresses(bodies, compute)
        assert len(computed) == 1
        assert kept_stresses(list(bodies), compute) != kept_stresses(bodies, compute)  # other bodies of the same roll
        kept_stresses(bodies_of("b"), compute)
        assert len(computed) == 3
    kept_stresses(bodies, compute)  # outside a series nothing is kept
    kept_stresses(bodies, compute)
    assert len(computed) == 5
