"""Make the published pages of studies, and their pictures, from the published tables.

Run: python docs/pictures/study_pages.py docs
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import polars

import surefoot as sf
from surefoot.control.registry import find_method
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.show import comparison_report
from surefoot.studies.engine.report import Report
from surefoot.studies.engine.study import Measured, Study
from surefoot.studies.push_map.map_numbers import MapNumbers
from surefoot.studies.push_map.question import PushMap
from surefoot.studies.push_map.show import report as map_report

COMPARE_PICTURES = {
    "pictures/shares.png": "compare-shares.png",
    "pictures/map-3.png": "compare-map-3.png",
}
"""Those of the page of all methods that are published, by their names in the report."""


def main(docs: Path) -> None:
    """Write them beside their tables."""
    robot = sf.load_robot("paper-biped")
    for name, pictures in (("compare", COMPARE_PICTURES), ("unified", {})):
        table = docs / "compare" / f"{name}.parquet"
        study = Comparison(robot.replace(mass=70.0))
        write(comparison_report(measured(study, table)), table, pictures)
    for name, picture in (("unified", "push-map.png"), ("hybrid", "push-map-hybrid.png")):
        table = docs / "push_maps" / f"{name}.parquet"
        grid = notes_of(table)["grid"]
        grid["support_side"] = sf.Side[grid["support_side"].upper()]
        controller = find_method(name).controller(robot.with_leg(max_speed=3.0), (0.5, 0.0))
        shown = MapNumbers(measured(PushMap(controller, **grid), table))
        write(map_report(shown), table, {"push-map.png": picture})


def notes_of(table: Path) -> dict[str, Any]:
    """What the file says beside its rows."""
    said = polars.read_parquet_metadata(table).items()
    return {
        name.removeprefix("surefoot."): json.loads(text)
        for name, text in said
        if name.startswith("surefoot.")
    }


def measured(study: Study, table: Path) -> Measured[Any]:
    """A table as if its study had just run."""
    notes = notes_of(table)
    return Measured(study, polars.read_parquet(table).to_dicts(), [], notes["provenance"], notes)


def write(report: Report, table: Path, published: dict[str, str]) -> None:
    """A report's page beside its table, and some of its pictures among the others."""
    pictures = report.pictures()
    table.with_suffix(".html").write_text(report.html(pictures), "utf-8")
    for name, picture in published.items():
        (table.parents[1] / "pictures" / picture).write_bytes(pictures[name])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
