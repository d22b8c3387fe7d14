"""Tables as text and HTML, and rows for pandas."""
from __future__ import annotations

import html
from typing import Any, Iterable, Optional, Sequence


def html_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Cells that begin with an <svg> are taken as they are."""
    def cell(text: str) -> str:
        return text if text.startswith("<svg") else html.escape(text)
    lines = ["<table><thead><tr>"]
    lines += [f"<th>{html.escape(text)}</th>" for text in heading]
    lines.append("</tr></thead><tbody>")
    for row in rows:
        lines.append("<tr>" + "".join(f"<td>{cell(text)}</td>" for text in row) + "</tr>")
    lines.append("</tbody></table>")
    return "".join(lines)


def interval_bar(low: float, high: float, interval: tuple[float, float], value: float) -> str:
    """The interval and the value within the range, 120 pixels wide."""
    def place(number: float) -> float:
        return 120.0 * min(max((number - low) / (high - low), 0.0), 1.0)
    left, right, middle = place(interval[0]), place(interval[1]), place(value)
    return ('<svg width="120" height="12" role="img"><rect y="5" width="120" height="2" fill="#ccc"/>'
            f'<rect x="{left:.1f}" y="3" width="{max(right - left, 1.0):.1f}" height="6" fill="#79c"/>'
            f'<rect x="{max(middle - 1.0, 0.0):.1f}" y="1" width="2" height="10" fill="#124"/></svg>')


def number(value: Optional[float]) -> str:
    return "" if value is None else f"{value:.5g}"


def between(interval: Optional[tuple[float, float]]) -> str:
    return "" if interval is None else f"{interval[0]:.5g} to {interval[1]:.5g}"


def frame(rows: list[dict[str, Any]], index: str) -> Any:
    """A pandas.DataFrame of rows. Raises ImportError without pandas, which decid does not need otherwise."""
    import pandas
    return pandas.DataFrame(rows).set_index(index)
