"""Properties of the pages of a report for generated texts and numbers (hypothesis, derandomised)."""

from __future__ import annotations

import math
import random
import re
from pathlib import Path
from xml.etree import ElementTree

from hypothesis import given, settings
from hypothesis import strategies as st
from support.paths import CONFIGS
from support.report_pages import words

from tests.fuzz.odd_folders import fill, outcome
from wroll_fem.case import load_case
from wroll_fem.report.html import folded, join, listing, notes, page, paragraph, subheading, table, terms
from wroll_fem.report.values import quantity, shown
from wroll_fem.results.summary import SUMMARY

SAME = settings(derandomize=True, deadline=None, max_examples=60)
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=30)
hostile = texts | st.sampled_from(
    [
        "</table>",
        "<script>x</script>",
        "]]>",
        "&amp;",
        "<!--",
        '" onload="x',
        "{{ 7 * 7 }}",
        "{% raw %}",
        "\x00\x1b[31m",
    ]
)
NOT_IN_XML = "[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
PREFIXES = {"p": 1e-12, "n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


def legible(text: str) -> str:
    """Text as a reader of the page sees it: characters that XML forbids are replaced, runs of blanks are one."""
    kept = re.sub(NOT_IN_XML, "\ufffd", text)
    return " ".join(kept.split())


@SAME
@given(title=hostile, cells=st.lists(st.tuples(hostile, hostile), min_size=1, max_size=4), other=hostile)
def test_any_text_stands_in_the_page_as_it_is(title: str, cells: list[tuple[str, str]], other: str) -> None:
    content = join(
        [paragraph(other), subheading(other), terms(cells), table(["a", "b"], cells), notes([(other, True)]),
         folded(other, listing(other))]
    )  # fmt: skip
    root = ElementTree.fromstring(page(title, other, [(title, content)]))
    assert {"script", "img", "iframe"}.isdisjoint(element.tag for element in root.iter())
    assert words(root.find("body/main/h1")) == legible(title)  # type: ignore[arg-type]
    found = [[words(cell) for cell in row] for row in root.iterfind(".//tbody/tr")]
    assert found == [[legible(cell) for cell in row] for row in cells]
    described = [words(e) for e in root.iter() if e.tag in ("dt", "dd")]
    assert described == [legible(cell) for row in cells for cell in row]
    for place in (".//li", ".//h3", ".//summary", ".//pre"):
        assert [words(element) for element in root.iterfind(place) if element.get("href") is None][-1] == legible(other)


@SAME
@given(st.floats(1e-12, 1e12) | st.floats(-1e12, -1e-12), st.sampled_from(["J", "Pa", "m", "N/m"]))
def test_a_quantity_is_read_back_to_four_digits(value: float, unit: str) -> None:
    number, name = quantity(value, unit).split(" ")
    assert name.endswith(unit)
    assert math.isclose(float(number) * PREFIXES[name.removesuffix(unit)], value, rel_tol=5.01e-4)


@settings(SAME, max_examples=200)
@given(
    st.sampled_from([*sorted(SUMMARY), "new_entry_hz", "text"]),
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | texts,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
        max_leaves=6,
    ),
)
def test_any_value_of_a_summary_is_shown_and_no_number_is_nan(name: str, value: object) -> None:
    told = shown(name, value)
    assert isinstance(told, str)
    if isinstance(value, float) and not math.isfinite(value):
        assert told == "none"
    if isinstance(value, float) and math.isfinite(value):
        assert not {"nan", "inf"} & set(told.split())


def test_a_folder_with_content_of_other_types_is_reported_or_refused_in_one_line(tmp_path: Path) -> None:
    """Some of the folders of `tests.fuzz.odd_folders`."""
    cases = [load_case(CONFIGS / f"{name}.yaml").model_dump(mode="json") for name in ("tiny", "lab_random", "two_dof")]
    told = set()
    for number in range(80):
        fill(tmp_path, cases, random.Random(f"7 {number}"))
        told.add(outcome(tmp_path))
    assert told == {"report", "one line"}
