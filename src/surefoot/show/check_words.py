"""What a check of a robot found, as lines that a person can read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence


def check_lines(findings: Sequence[Mapping[str, str]]) -> list[str]:
    """One line for what is well, three for what is not.

    Args:
        findings: with check, verdict, expected, got and remedy.
    """
    width = max(len(finding["check"]) for finding in findings)
    lines = []
    for finding in findings:
        verdict = finding["verdict"]
        head = f"{verdict:7}"
        if verdict == "ok":
            lines.append(f"{head}  {finding['check']:{width}}  {finding['got']}")
            continue
        indent = " " * (11 + width)
        lines += [
            f"{head}  {finding['check']:{width}}  expected {finding['expected']}",
            f"{indent}got {finding['got']}",
            f"{indent}do this: {finding['remedy']}",
        ]
    return lines


def check_verdict(name: str, findings: Sequence[Mapping[str, str]]) -> str:
    """The last line."""
    counts = {
        noun: sum(finding["verdict"] == noun for finding in findings)
        for noun in ("problem", "warning")
    }
    told = [f"{count} {noun}{'s' * (count > 1)}" for noun, count in counts.items() if count]
    return f"{name}: {' and '.join(told) if told else 'all is well'}"
