"""A statement of a paper beside what was measured."""

from __future__ import annotations

from dataclasses import dataclass

REPRODUCED = "reproduced"
UNDER_ASSUMPTIONS = "reproduced under stated assumptions"
NOT_REPRODUCED = "not reproduced"


@dataclass(frozen=True)
class Claim:
    """One statement of the paper and what became of it.

    Attributes:
        figure: where the paper makes it.
        text: the situation.
        paper: what the paper reports.
        ours: what is measured.
        verdict: `REPRODUCED`, `UNDER_ASSUMPTIONS` or `NOT_REPRODUCED`.
        why: the assumptions, or the reason for a difference.
    """

    figure: str
    text: str
    paper: str
    ours: str
    verdict: str
    why: str
