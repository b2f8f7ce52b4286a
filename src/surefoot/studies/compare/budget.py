"""The noise-and-delay budget: what is left of each method's margin under each disturbance."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure as Picture
from matplotlib.patches import Rectangle

from surefoot.show import palette
from surefoot.studies.compare.disturbances import UNDISTURBED
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import share, situation, survived
from surefoot.studies.engine.pictures import headline, panel, without_frame
from surefoot.studies.engine.report import Details, Figure, Report, Table, Text, provenance
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row
from surefoot.studies.engine.words import TIME_WORDS, percent

HEADING = "What is left of the margin"

RULE = (
    f"A push is survived if the robot has not fallen {TIME_WORDS} after it, with the same rule "
    "for the undisturbed walk: under noise no method is back on the gait. The limit is the "
    "theoretical one of the robot that is really pushed, undisturbed. Where a disturbance takes "
    "several walks, one for each seed or direction, the worst counts."
)

_LABELS, _ROW, _COLUMN, _HEAD, _FOOT, _RIGHT = 2.45, 0.42, 0.5, 2.15, 0.85, 1.2
_CHANGES = LinearSegmentedColormap.from_list(
    "changes", ["#f08a3c", "#ffffff", "#5fb3e6"]
)  # fmt: skip
_RANGE = Normalize(-0.5, 0.5, clip=True)
"""Change of the share, as a fraction of what it was undisturbed."""


@dataclass(frozen=True)
class Retained:
    """What is left of the margin of one method under one disturbance; means over `cells` pushes.

    Attributes:
        share: what is survived as a share of the limit, in the worst walk.
        lost: what is survived less than undisturbed, in the worst walk; nan without those [N s].
        mean_share: like `share`, over all walks.
        mean_lost: like `lost`, over all walks [N s].
        before: the share without any disturbance, of the same pushes.
        cells: how many pushes.
    """

    share: float
    lost: float
    mean_share: float
    mean_lost: float
    before: float
    cells: int

    @property
    def change(self) -> float:
        """Of the share, as a fraction of what it was; nan if that is not known, or was 0."""
        return (self.share - self.before) / self.before if self.before > 0.0 else math.nan


def retained(measured: Measured[Comparison]) -> dict[tuple[str, str], Retained]:
    """What is left, by the keys of method and disturbance; what was not measured is missing."""
    at = {(row["method"], row["disturbance"], situation(row)): row for row in measured.rows}
    found = {}
    for method in measured.notes["methods"]:
        for disturbance in measured.notes["disturbances"]:
            pair = (method["key"], disturbance["key"])
            rows = [row for (*one, _), row in at.items() if tuple(one) == pair]
            before = [at.get((pair[0], UNDISTURBED, situation(row))) for row in rows]
            if rows:
                found[pair] = _retained(list(zip(rows, before, strict=True)))
    return found


def _retained(pairs: Sequence[tuple[Row, Row | None]]) -> Retained:
    both = [(row, before) for row, before in pairs if before is not None]
    return Retained(
        share=_mean(share(row) for row, _ in pairs),
        lost=_mean(survived(before) - survived(row) for row, before in both),
        mean_share=_mean(share(row, survives="survived_mean") for row, _ in pairs),
        mean_lost=_mean(before["survived_mean"] - row["survived_mean"] for row, before in both),
        before=_mean(share(before) for _, before in both),
        cells=len(pairs),
    )


def _mean(values: Iterable[float]) -> float:
    finite = [value for value in values if not math.isnan(value)]
    return math.fsum(finite) / len(finite) if finite else math.nan


def budget_report(measured: Measured[Comparison]) -> Report:
    """The report of a comparison with disturbances."""
    found = retained(measured)
    pushes = len({situation(row) for row in measured.rows})
    methods, disturbances = measured.notes["methods"], measured.notes["disturbances"]
    drawn = [one for one in disturbances if one["walks"] > 1]

    def table(
        title: str, words: Callable[[Retained], str], rows: Sequence[dict[str, Any]] = disturbances
    ) -> Table:
        lines = []
        for one in rows:
            kept = [found.get((method["key"], one["key"])) for method in methods]
            label = one["label"] + (f" ({one['walks']} walks)" if one["walks"] > 1 else "")
            lines.append((label, *("–" if each is None else words(each) for each in kept)))
        return Table(title, "", ("disturbance", *(m["label"] for m in methods)), lines)

    parts: list[Any] = [
        Text(RULE),
        Text(f"Means over {pushes} pushes."),
        Figure(
            "budget.png",
            "Share of the limit of every method under every disturbance",
            partial(budget_figure, measured),
        ),
        table("Share of the limit that is kept", lambda kept: percent(kept.share)),
        table("Change against undisturbed [N s]", lambda kept: lost_words(kept.lost)),
    ]
    if drawn:
        mean = table(
            "", lambda kept: f"{percent(kept.mean_share)}, {lost_words(kept.mean_lost)}", drawn
        )
        parts.append(Details("The same as means over all walks of a disturbance", [mean]))
    whole = len(found) == len(methods) * len(disturbances)
    if not whole or any(one.cells < pushes for one in found.values()):
        parts.append(Text("Not everything was measured on every push: – was not measured."))
    parts.append(provenance(measured.provenance))
    return Report("budget", HEADING, (measured.provenance.get("robot", ""),), parts)


def lost_words(lost: float) -> str:
    """What was lost as a change, with its sign and a real minus; – if it is not known [N s]."""
    if math.isnan(lost):
        return "–"
    text = f"{-lost:+.1f}" if abs(lost) < 9.95 else f"{-lost:+.0f}"
    return "0" if float(text) == 0.0 else text.replace("-", "\N{MINUS SIGN}")


def budget_figure(measured: Measured[Comparison]) -> Picture:
    """A field for each method (row) and disturbance (column): share of the limit, and N s lost."""
    methods, disturbances = measured.notes["methods"], measured.notes["disturbances"]
    rows, columns = len(methods), len(disturbances)
    width = max(_LABELS + _COLUMN * columns + _RIGHT, 7.0)
    height = _HEAD + _ROW * rows + _FOOT
    figure = Picture(figsize=(width, height), facecolor="white")
    ax = panel(figure, _LABELS, _FOOT, _COLUMN * columns, _ROW * rows)
    ax.set_xlim(0.0, columns)
    ax.set_ylim(rows, 0.0)
    ax.set_yticks([row + 0.5 for row in range(rows)])
    ax.set_yticklabels([method["label"] for method in methods], fontsize=8.5)
    ax.xaxis.tick_top()
    ax.set_xticks([column + 0.5 for column in range(columns)])
    ax.set_xticklabels(
        [one["label"] for one in disturbances], fontsize=8.0, rotation=45.0, ha="left",
        rotation_mode="anchor",
    )  # fmt: skip
    without_frame(ax)
    found = retained(measured)
    for row, method in enumerate(methods):
        for column, one in enumerate(disturbances):
            pair = (method["key"], one["key"])
            _draw_field(ax, row, column, found.get(pair), pair)
    robot = measured.provenance.get("robot", "")
    headline(figure, robot, "what is left of the margin")
    _explain(figure, width, height)
    return figure


def _draw_field(
    ax: Axes, row: int, column: int, kept: Retained | None, pair: tuple[str, str]
) -> None:
    colour = "#f0f0f0"
    if kept is not None and pair[1] != UNDISTURBED and not math.isnan(kept.change):
        colour = _CHANGES(_RANGE(kept.change))
    look = {"facecolor": colour, "edgecolor": "white", "linewidth": 1.5}
    ax.add_patch(Rectangle((column, row), 1.0, 1.0, gid=f"field-{pair[0]}-{pair[1]}", **look))
    if kept is None:
        ax.text(column + 0.5, row + 0.5, "–", ha="center", va="center", color=palette.QUIET)
        return
    alone = pair[1] == UNDISTURBED or math.isnan(kept.lost)
    ax.text(
        column + 0.5, row + (0.5 if alone else 0.36), f"{100.0 * kept.share:.0f}",
        ha="center", va="center", fontsize=9.0, fontweight="bold" if alone else "normal",
    )  # fmt: skip
    if not alone:
        ax.text(
            column + 0.5, row + 0.75, lost_words(kept.lost), ha="center", va="center",
            fontsize=6.5, color="#333333",
        )  # fmt: skip


def _explain(figure: Picture, width: float, height: float) -> None:
    quiet = {"fontsize": 8.0, "color": "#333333", "va": "center"}
    bar = panel(figure, _LABELS, 0.42, 1.7, 0.13)
    bar.imshow(
        [[step / 60.0 - 0.5 for step in range(61)]], cmap=_CHANGES, norm=_RANGE, aspect="auto",
        extent=(-50.0, 50.0, 0.0, 1.0),
    )  # fmt: skip
    bar.set_yticks([])
    bar.set_xticks([-50, 0, 50])
    bar.set_xticklabels(["half lost", "unchanged", "half more"], fontsize=7.0)
    bar.tick_params(pad=2.0)
    without_frame(bar)
    words = (
        "Large: what is survived in the worst walk, % of the theoretical limit.",
        "Small: change against undisturbed [N s]. Means over all pushes.",
    )
    for line, text in enumerate(words):
        figure.text(
            (_LABELS + 2.1) / width, (0.52 - 0.2 * line) / height, text, **quiet
        )  # fmt: skip
