"""What a tuning shows: a report with its table and its picture, and the notes of its settings."""

from __future__ import annotations

from surefoot.studies.engine.report import Details, Figure, Report, Table, Text, word_table
from surefoot.studies.tune.picture import tune_figure
from surefoot.studies.tune.search import Tuned
from surefoot.studies.tune.words import (
    COLUMNS,
    RULE,
    changes,
    dropped_words,
    front_rows,
    outcome,
    score_rows,
    title,
    verdict,
)
from surefoot.version import VERSION


def report(tuned: Tuned, command: str) -> Report:
    """All of a tuning; `command` walks with the settings."""
    about = tuned.provenance
    reasons = changes(tuned)
    words = [outcome(tuned), *reasons, dropped_words(tuned)]
    alone = (
        ["What is lost without a parameter is measured with it alone set back."] if reasons else []
    )
    return Report(
        name="tune",
        heading=title(tuned),
        origin=(f"{about['trials']} trials", f"seed {about['seed']}"),
        parts=[
            *(Text(one) for one in words if one),
            Table("Does it hold?", verdict(tuned), COLUMNS, score_rows(tuned), names=2),
            Figure(
                "tune.png", "Survival over gentleness of every trial",
                lambda: tune_figure(tuned),
            ),
            Details(
                "What is measured",
                [Text(" ".join([RULE, f"The small pushes have {about['small push']}.", *alone]))],
            ),
            Details(
                "What else there is",
                [
                    Text("The trials on the Pareto front, whatever is preferred."),
                    Table("", "", ("trial", "survived", "gentleness", "values"), front_rows(tuned)),
                ],
            ),
            Details("Walk with it", [Text(f"`{command}`")]),
            Details("Provenance", [word_table(("what", "value"), about)]),
        ],
    )  # fmt: skip


def settings_notes(tuned: Tuned, command: str) -> list[str]:
    """What stands above the settings in their file."""
    about = tuned.provenance
    return [
        f"{title(tuned)} (Surefoot {VERSION}, {about['trials']} trials, seed {about['seed']})",
        *changes(tuned),
        *([verdict(tuned)] if tuned.changed else []),
        f"Walk with it: {command}",
    ]
