"""The page and the pictures of a push map in a folder, and its summary as a table."""

from __future__ import annotations

from pathlib import Path

from matplotlib import style
from rich.console import Console
from rich.table import Table

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.show.report_files import write_files
from surefoot.studies.engine.words import angle_words, percent
from surefoot.studies.push_map.cube import PushCube
from surefoot.studies.push_map.push_cube_figure import heat_figure, polar_figure
from surefoot.studies.push_map.push_cube_page import cube_page
from surefoot.studies.push_map.push_cube_words import finding, origin

PAGE, HEAT, POLAR = "push-map.html", "push-map.png", "push-map-polar.png"
"""Names of the files."""


def write_cube_report(cube: PushCube, folder: Path) -> list[Path]:
    """Write page and pictures; the same map makes the same bytes.

    Args:
        cube: the map.
        folder: where to write; it exists.

    Returns:
        The files, the page first.

    Raises:
        FileError: the folder cannot be written to.
    """
    contents = {PAGE: cube_page(cube).encode()}
    for name, draw in ((HEAT, heat_figure), (POLAR, polar_figure)):
        with style.context(["default", palette.STYLE]):
            figure = draw(cube)
        contents[name] = picture_bytes(figure, "png", origin(cube))
    return write_files(contents, folder)


def print_cube(cube: PushCube, console: Console) -> None:
    """Print the map along the axes, over all phases, and what it comes to."""
    table = Table(title=origin(cube), title_justify="left")
    for heading in ("direction", "survived [N s]", "limit [N s]", "mean share", "worst"):
        table.add_column(heading, justify="left" if heading == "direction" else "right")
    for angle in DIRECTIONS.values():
        (columns,) = (cube.angles == angle).nonzero()
        if len(columns) == 0:
            continue
        survived, limit = cube.survived[:, columns[0]], cube.limit[:, columns[0]]
        share = cube.share[:, columns[0]]
        table.add_row(
            angle_words(angle),
            f"{survived.min():g} to {survived.max():g}",
            f"{limit.min():.0f} to {limit.max():.0f}",
            percent(float(share.mean())),
            percent(float(share.min())),
        )
    console.print(table)
    console.print(finding(cube), highlight=False)
